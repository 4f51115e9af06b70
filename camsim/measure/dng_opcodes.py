"""Opcode lists of a DNG: operations on the samples (specification 1.7, chapters 6 and 7).

The first list applies to stored samples, the second to linear ones from black, 0, to white, 1. The third is for
developed pictures and is not applied to raw ones.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64
from camsim.errors import InputError
from camsim.files.tiff_reader import Directory

_LISTS = {1: 51008, 2: 51009, 3: 51022}
_LONGEST = 64 << 20
_NAMES = {
    1: "WarpRectilinear", 2: "WarpFisheye", 3: "FixVignetteRadial", 4: "FixBadPixelsConstant", 5: "FixBadPixelsList",
    6: "TrimBounds", 7: "MapTable", 8: "MapPolynomial", 9: "GainMap", 10: "DeltaPerRow", 11: "DeltaPerColumn",
    12: "ScalePerRow", 13: "ScalePerColumn", 14: "WarpRectilinear2",
}  # fmt: skip
_Apply: TypeAlias = Callable[[Any, bytes, tuple[int, int]], Any]

_REPAIRS = (4, 5)
_IN_PROPORTION = (3, 9, 12, 13)
"""Multiplications: codes stay proportional to charge, with a separate gain for each photosite."""


@dataclass(frozen=True, slots=True)
class Operation:
    """One entry of a list: its number, whether a reader may leave it out, and its parameters."""

    code: int
    optional: bool
    body: bytes

    @property
    def name(self) -> str:
        """Name of the operation in the specification."""
        return _NAMES.get(self.code, f"operation {self.code}")


@dataclass(frozen=True, slots=True)
class Operations:
    """The opcode lists of an image that affect its samples."""

    first: tuple[Operation, ...]
    second: tuple[Operation, ...]
    third: tuple[Operation, ...]

    @classmethod
    def of(cls, directory: Directory) -> Operations:
        """Return the opcode lists in an image's directory; raises InputError for a truncated list."""
        return cls(*(tuple(_listed(directory, number)) for number in _LISTS))

    def stated(self) -> tuple[str, ...]:
        """Return texts on the operations that are applied and those that are not."""
        known: tuple[dict[int, _Apply], ...] = (_ON_STORED, _ON_LINEAR, {})
        return tuple(
            f"OpcodeList{number} {one.name}: {'applied' if one.code in applied else 'not applied'}"
            for number, operations, applied in zip(_LISTS, (self.first, self.second, self.third), known, strict=True)
            for one in operations
        )

    def on_stored(self, image: npt.NDArray[Any], period: tuple[int, int]) -> npt.NDArray[Any]:
        """Apply the first list to stored samples, or raise with an operation's name; ``period``: of the filters."""
        for one in self.first:
            if one.code in _ON_STORED:
                image = _applied(1, one, _ON_STORED[one.code], image, period)
            elif not one.optional:
                raise _refusal(1, one)
        return image

    def on_linear(self, light: F64, period: tuple[int, int]) -> F64:
        """Apply the second list to samples from 0 (black) to 1 (white), or raise with an operation's name.

        Clipped samples stay clipped. ``period``: of the filter array.
        """
        full = light >= 1.0
        for one in self.second:
            if one.code in _ON_LINEAR:
                light = _applied(2, one, _ON_LINEAR[one.code], light, period)
            elif not one.optional:
                raise _refusal(2, one)
        return np.where(full, 1.0, np.minimum(light, 1.0))

    @property
    def on_light(self) -> bool:
        """Whether the second list has any operation."""
        return any(one.code in _ON_LINEAR or not one.optional for one in self.second)

    def refuse_curves(self) -> None:
        """Raise if operations make light differ from stored codes times a gain: noise is measured in stored codes."""
        for number, operations in ((1, self.first), (2, self.second)):
            for one in operations:
                if one.code not in (*_REPAIRS, *_IN_PROPORTION) and not one.optional:
                    raise _refusal(number, one)


def _listed(directory: Directory, number: int) -> Iterator[Operation]:
    data = directory.bytes_of(_LISTS[number], _LONGEST)
    at = 4
    for _ in range(int.from_bytes(data[:4])):
        size = int.from_bytes(data[at + 12 : at + 16])
        if at + 16 + size > len(data):
            raise InputError(f"its OpcodeList{number} is cut short")
        code, optional = int.from_bytes(data[at : at + 4]), data[at + 11] & 1
        yield Operation(code, bool(optional), data[at + 16 : at + 16 + size])
        at += 16 + size


def _refusal(number: int, one: Operation) -> InputError:
    return InputError(
        f"its OpcodeList{number} asks for {one.name}, which changes what its samples mean and is not applied; have the "
        "program that wrote it apply it, or mark it as optional"
    )


def _applied(number: int, one: Operation, apply: _Apply, samples: Any, period: tuple[int, int]) -> Any:
    try:
        return apply(samples, one.body, period)
    except (struct.error, ValueError, IndexError, OverflowError):
        raise InputError(f"its OpcodeList{number} has a {one.name} that is cut short or damaged") from None


def _constant(image: npt.NDArray[Any], body: bytes, period: tuple[int, int]) -> npt.NDArray[Any]:
    [value, _] = struct.unpack_from(">2I", body)
    return _mended(image, image == value, period)


def _bad_list(image: npt.NDArray[Any], body: bytes, period: tuple[int, int]) -> npt.NDArray[Any]:
    _, points, rectangles = struct.unpack_from(">3I", body)
    numbers = np.frombuffer(body, ">u4", 2 * points + 4 * rectangles, 12).astype(np.int64)
    bad = np.zeros(image.shape, np.bool_)
    places = numbers[: 2 * points].reshape(-1, 2)
    places = places[(places[:, 0] < image.shape[0]) & (places[:, 1] < image.shape[1])]
    bad[places[:, 0], places[:, 1]] = True
    for top, left, bottom, right in numbers[2 * points :].reshape(-1, 4).tolist():
        bad[top:bottom, left:right] = True
    return _mended(image, bad, period)


def _mended(image: npt.NDArray[Any], bad: npt.NDArray[np.bool_], period: tuple[int, int]) -> npt.NDArray[Any]:
    """Return an image whose bad samples are the mean of the nearest good ones behind the same filter."""
    out = image.copy()
    for row, col in np.argwhere(bad).tolist():
        for reach in range(1, 9):
            near = [
                (row + reach * period[0] * down, col + reach * period[1] * across)
                for down, across in ((-1, 0), (1, 0), (0, -1), (0, 1))
            ]
            good = [
                image[place] for place in near
                if 0 <= place[0] < image.shape[0] and 0 <= place[1] < image.shape[1] and not bad[place]
            ]  # fmt: skip
            if good:
                mean = np.mean(good, axis=0)
                out[row, col] = np.rint(mean) if image.dtype.kind in "ui" else mean
                break
    return out


@dataclass(frozen=True, slots=True)
class _Area:
    """Area of an operation: every ``pitch``-th row and column of a rectangle, in some planes."""

    where: tuple[slice, slice, slice]
    rest: bytes

    @classmethod
    def of(cls, body: bytes, shape: Sequence[int]) -> _Area:
        top, left, bottom, right, plane, planes, down, across = struct.unpack_from(">8I", body)
        if not (down and across):
            raise ValueError
        rows = slice(top, min(bottom, shape[0]), down)
        return cls((rows, slice(left, min(right, shape[1]), across), slice(plane, plane + planes)), body[32:])

    def lines(self, shape: Sequence[int]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """Return the rows and the columns."""
        return np.arange(shape[0])[self.where[0]], np.arange(shape[1])[self.where[1]]


def _in_area(light: F64, body: bytes, change: Callable[[F64, _Area], F64]) -> F64:
    """Return an image with ``change`` applied to the samples (rows, cols, planes) of the area."""
    out = light.copy()
    cube = out if out.ndim == 3 else out[:, :, None]
    area = _Area.of(body, cube.shape)
    cube[area.where] = change(cube[area.where], area)
    return out


def _table(light: F64, body: bytes, _: tuple[int, int]) -> F64:
    def change(values: F64, area: _Area) -> F64:
        [count] = struct.unpack_from(">I", area.rest)
        table = np.frombuffer(area.rest, ">u2", count, 4).astype(np.float64)
        at = np.clip(np.rint(values * 65535.0), 0, count - 1).astype(np.intp)
        mapped: F64 = table[at] / 65535.0
        return mapped

    return _in_area(light, body, change)


def _polynomial(light: F64, body: bytes, _: tuple[int, int]) -> F64:
    def change(values: F64, area: _Area) -> F64:
        [degree] = struct.unpack_from(">I", area.rest)
        coefficients = np.frombuffer(area.rest, ">f8", degree + 1, 4)
        mapped: F64 = np.polynomial.polynomial.polyval(values, coefficients)
        return mapped

    return _in_area(light, body, change)


def _gain_map(light: F64, body: bytes, _: tuple[int, int]) -> F64:
    def change(values: F64, area: _Area) -> F64:
        down, across, step_v, step_h, first_v, first_h, planes = struct.unpack_from(">2I4dI", area.rest)
        gains = np.frombuffer(area.rest, ">f4", down * across * planes, 44).astype(np.float64)
        gains = gains.reshape(down, across, planes)
        rows, cols = area.lines(light.shape)
        # Positions are fractions of the image; the map is extended by its rim.
        v = np.clip(((rows + 0.5) / light.shape[0] - first_v) / (step_v or 1.0), 0.0, down - 1.0)
        h = np.clip(((cols + 0.5) / light.shape[1] - first_h) / (step_h or 1.0), 0.0, across - 1.0)
        at_v, at_h = np.minimum(v.astype(np.intp), max(down - 2, 0)), np.minimum(h.astype(np.intp), max(across - 2, 0))
        to_v, to_h = np.minimum(at_v + 1, down - 1), np.minimum(at_h + 1, across - 1)
        part_v, part_h = (v - at_v)[:, None, None], (h - at_h)[None, :, None]
        above = gains[at_v][:, at_h] * (1.0 - part_h) + gains[at_v][:, to_h] * part_h
        below = gains[to_v][:, at_h] * (1.0 - part_h) + gains[to_v][:, to_h] * part_h
        gain = above * (1.0 - part_v) + below * part_v
        # If a map has fewer planes than the image, its last is reused.
        multiplied: F64 = values * gain[:, :, np.minimum(np.arange(values.shape[2]), planes - 1)]
        return multiplied

    return _in_area(light, body, change)


def _by_line(axis: int, combine: Callable[[F64, F64], F64]) -> Callable[[F64, bytes, tuple[int, int]], F64]:
    def apply(light: F64, body: bytes, _: tuple[int, int]) -> F64:
        def change(values: F64, area: _Area) -> F64:
            [count] = struct.unpack_from(">I", area.rest)
            each = np.frombuffer(area.rest, ">f4", count, 4).astype(np.float64)[: values.shape[axis]]
            if each.size < values.shape[axis]:
                raise ValueError
            return combine(values, np.expand_dims(each, tuple(k for k in range(3) if k != axis)))

        return _in_area(light, body, change)

    return apply


def _vignette(light: F64, body: bytes, _: tuple[int, int]) -> F64:
    *terms, centre_x, centre_y = struct.unpack_from(">7d", body)
    rows, cols = light.shape[:2]
    x, y = np.arange(cols) + 0.5 - centre_x * cols, np.arange(rows) + 0.5 - centre_y * rows
    farthest = max(abs(centre_x), abs(1.0 - centre_x)) * cols, max(abs(centre_y), abs(1.0 - centre_y)) * rows
    r2 = (x[None, :] ** 2 + y[:, None] ** 2) / (farthest[0] ** 2 + farthest[1] ** 2)
    gain = 1.0 + r2 * np.polynomial.polynomial.polyval(r2, terms)
    multiplied: F64 = light * (gain if light.ndim == 2 else gain[:, :, None])
    return multiplied


def _plus(values: F64, each: F64) -> F64:
    return values + each


def _times(values: F64, each: F64) -> F64:
    return values * each


_ON_STORED: dict[int, _Apply] = {4: _constant, 5: _bad_list}
_ON_LINEAR: dict[int, _Apply] = {
    **_ON_STORED, 3: _vignette, 7: _table, 8: _polynomial, 9: _gain_map, 10: _by_line(0, _plus), 11: _by_line(1, _plus),
    12: _by_line(0, _times), 13: _by_line(1, _times),
}  # fmt: skip
