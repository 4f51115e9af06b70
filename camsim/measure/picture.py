"""Picture: linear image data for measurements, as planes sampled on separate lattices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.core.arrays import F64, is_masked
from camsim.core.number_kinds import array_of
from camsim.core.typed import Count, Index, Positive, check
from camsim.core.words import displayed
from camsim.errors import InvalidValueError, UnknownNameError
from camsim.measure.full_frame import FullFrame
from camsim.measure.geometry import Roi
from camsim.measure.libraw import Noted
from camsim.numerics.filtering import bell, filtered

LARGEST_SIGNAL = 1e30
"""Larger than any light, electrons or codes; its eighth power is still finite."""

_NUMBER = int | float | np.integer | np.floating

_LONGEST_PERIOD = 24
"""Longest period, photosites: black levels every 8 rows under X-Trans."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plane:
    """One lattice of photosites, every ``step``-th row and column; planes of one name are one channel.

    name         : R, G1 (green in the rows of red), G2, B; Y for one channel; or the name in the file
    samples      : (n, m) values proportional to light, above ``black``
    first, step  : row and column of samples[0, 0] in the image, and the distance between samples, both (rows, cols)
    black, white : signal without light, and the clipping level (None: no clipping)
    lowest       : the smallest number that can be stored (None: no limit); many of these are clipped shadows
    holds_dark   : whether it includes dark charge, as codes and electrons with noise do
    """

    name: str
    samples: npt.NDArray[Any]
    first: tuple[int, int] = (0, 0)
    step: tuple[int, int] = (1, 1)
    black: float = 0.0
    white: float | None = None
    lowest: float | None = None
    holds_dark: bool = False

    def __post_init__(self) -> None:
        check(self.name, str, "Plane.name")
        converted: dict[str, Any] = {
            "samples": _numbers(self.samples, self.name),
            "first": check(self.first, tuple[Index, Index], "first", self.name),
            "step": check(self.step, tuple[Count, Count], "step", self.name),
        }
        for key in ("black", "white", "lowest"):
            level = getattr(self, key)
            if level is None and key != "black":
                continue
            number = math.nan if isinstance(level, bool) or not isinstance(level, _NUMBER) else float(level)
            if not abs(number) <= LARGEST_SIGNAL:
                message = f"{displayed(level)}; must be a number up to {LARGEST_SIGNAL:g}"
                raise InvalidValueError(message, key=key, stage=self.name)
            converted[key] = number  # so that it can be subtracted from unsigned codes
        for key, value in converted.items():
            object.__setattr__(self, key, value)

    def check_inside(self, shape: tuple[int, int]) -> None:
        """Raise for a lattice that does not cover a picture of (rows, cols)."""
        for what, first, step, count, size in zip(
            ("rows", "columns"), self.first, self.step, self.samples.shape, shape, strict=True
        ):
            if count != len(range(first, size, step)) or first >= step:
                lattice = f"has {count} {what} of samples, every {step} from {first} on"
                message = f"{lattice}, and the picture's shape is {shape[0]} rows × {shape[1]} columns"
                raise InvalidValueError(message, key="samples", stage=self.name)

    @property
    def reach(self) -> tuple[int, int]:
        """Rows and columns of an image that ends where the next samples would be."""
        rows, cols = (f + s * n for f, s, n in zip(self.first, self.step, self.samples.shape, strict=True))
        return rows, cols

    def cut(self, roi: Roi) -> tuple[npt.NDArray[Any], F64, F64]:
        """Return the samples (n, m) in a region, and their centres: x (m,) and y (n,) in pixels of the image."""
        rows, cols = (
            slice(-(-(start - first) // step), -(-(start + size - first) // step))
            for start, size, first, step in zip(
                (roi.row, roi.col), (roi.rows, roi.cols), self.first, self.step, strict=True
            )
        )
        inside = self.samples[max(rows.start, 0) : rows.stop, max(cols.start, 0) : cols.stop]
        y = self.first[0] + 0.5 + self.step[0] * (max(rows.start, 0) + np.arange(inside.shape[0], dtype=np.float64))
        x = self.first[1] + 0.5 + self.step[1] * (max(cols.start, 0) + np.arange(inside.shape[1], dtype=np.float64))
        return inside, x, y


def _numbers(samples: Any, name: str) -> npt.NDArray[Any]:
    """Return an image as a 2-D array; raises for three axes, as rows and columns would be ambiguous."""
    if is_masked(samples):
        raise InvalidValueError("has masked samples; give all, or a smaller region", key="samples", stage=name)
    array = array_of(samples, "samples", name)
    if array.ndim != 2 or array.dtype.kind not in "fiu":
        given = f"{array.dtype} of shape {array.shape}"
        raise InvalidValueError(f"must be (n, m) real numbers, not {given}", key="samples", stage=name)
    return array


@dataclass(frozen=True, slots=True)
class Samples:
    """The photosites of a channel in a region: signals as stored and above black, centres in pixels, all flat."""

    stored: npt.NDArray[Any]
    signal: F64
    x: F64
    y: F64


@dataclass(frozen=True, slots=True)
class Channel:
    """All photosites of one colour: one lattice, or several (X-Trans, quad Bayer)."""

    planes: tuple[Plane, ...]

    @property
    def name(self) -> str:
        """The name that all its planes have."""
        return self.planes[0].name

    @property
    def reach(self) -> tuple[int, int]:
        """Rows and columns of an image that ends where the next samples of its planes would be."""
        rows, cols = (max(sizes) for sizes in zip(*(plane.reach for plane in self.planes), strict=True))
        return rows, cols

    @property
    def pitch_pixel(self) -> float:
        """Distance between samples, the longer one of a lattice; for several, that of a square lattice as dense."""
        if len(self.planes) == 1:
            return self.period_pixel
        return 1.0 / math.sqrt(sum(1.0 / math.prod(plane.step) for plane in self.planes))

    @property
    def period_pixel(self) -> float:
        """Distance after which the pattern of samples repeats: the longer one of those along x and y."""
        return float(max(self.planes[0].step))

    @property
    def gap_pixel(self) -> float:
        """Longest distance along a pixel axis between columns, or rows, with samples."""
        gaps = []
        for axis in (0, 1):
            period = self.planes[0].step[axis]
            places = sorted({plane.first[axis] % period for plane in self.planes})
            gaps.append(max(b - a for a, b in pairwise([*places, places[0] + period])))
        return float(max(gaps))

    @property
    def nyquist_cycles_per_pixel(self) -> float:
        """Half the sampling frequency; for several lattices that of a square lattice of the same density of samples."""
        return 0.5 / self.pitch_pixel

    def inside(self, roi: Roi) -> Samples:
        """Return the photosites in a region."""
        cuts = [(*plane.cut(roi), plane.black) for plane in self.planes]
        grids = [np.broadcast_arrays(x[None, :], y[:, None]) for _, x, y, _ in cuts]
        return Samples(
            stored=_joined([stored for stored, *_ in cuts]),
            signal=_joined([stored.astype(np.float64) - black for stored, _, _, black in cuts]),
            x=_joined([x for x, _ in grids]),
            y=_joined([y for _, y in grids]),
        )

    def on_a_lattice(self, roi: Roi) -> tuple[F64, F64, F64]:
        """Return signals above black (n, m) on a rectangular lattice, with its centres x (m,) and y (n,).

        For one lattice, its samples. For several, a smooth picture for edge detection: Gaussian-weighted means of
        the samples around each position.
        """
        if len(self.planes) == 1:
            stored, x, y = self.planes[0].cut(roi)
            return stored.astype(np.float64) - self.planes[0].black, x, y
        total, weight = np.zeros((roi.rows, roi.cols)), np.zeros((roi.rows, roi.cols))
        for plane in self.planes:
            stored, x, y = plane.cut(roi)
            where = np.ix_((y - roi.row).astype(np.intp), (x - roi.col).astype(np.intp))
            total[where], weight[where] = stored - plane.black, 1.0
        width, every = 0.3 * self.period_pixel, max(1, math.floor(self.pitch_pixel))
        near = bell(width, truncate=8.0)
        blurred, weights = (filtered(part, near, near) for part in (total, weight))
        smooth = blurred / np.maximum(weights, 1e-12)
        x = roi.col + 0.5 + np.arange(0, roi.cols, every, dtype=np.float64)
        y = roi.row + 0.5 + np.arange(0, roi.rows, every, dtype=np.float64)
        return smooth[::every, ::every], x, y


def _joined(parts: list[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    return parts[0].ravel() if len(parts) == 1 else np.concatenate([part.ravel() for part in parts])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """An image to measure in.

    name        : name of the picture in messages
    shape       : (rows, cols)
    planes      : lattices of its channels
    pitch_um    : distance between photosites, None if unknown
    description : the description of its computation in the file; None for other files
    noted       : metadata of a maker's raw file or a DNG
    """

    name: str
    shape: tuple[int, int]
    planes: tuple[Plane, ...]
    pitch_um: float | None = None
    description: Mapping[str, Any] | None = field(default=None, repr=False)
    noted: Noted | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        planes = check(self.planes, tuple[Plane, ...], "planes", "Picture")
        shape = check(self.shape, tuple[Count, Count], "shape", "Picture")
        pitch_um = check(self.pitch_um, Positive | None, "pitch_um", "Picture")
        for plane in planes:
            plane.check_inside(shape)
        places = [(p.name, *(f % s for f, s in zip(p.first, p.step, strict=True))) for p in planes]
        if len(set(places)) < len(places):
            raise InvalidValueError(
                "two of one name hold the same photosites; give each channel a different name",
                key="planes",
                stage=self.name,
            )
        for key, value in (("planes", planes), ("shape", shape), ("pitch_um", pitch_um)):
            object.__setattr__(self, key, value)

    @property
    def full_frame(self) -> FullFrame:
        """The camera's full frame, as far as the file states it."""
        return FullFrame.of(self.description, self.shape)

    def select(self, channel: str) -> tuple[Channel, ...]:
        """Return the channels of a name: one, or every channel for ``all``."""
        names = list(dict.fromkeys(plane.name for plane in self.planes))
        if check(channel, str, "channel") not in ("all", *names):
            raise UnknownNameError("channel", channel, ["all", *names])
        chosen = names if channel == "all" else [channel]
        return tuple(Channel(tuple(plane for plane in self.planes if plane.name == name)) for name in chosen)


def mosaic_planes(
    samples: npt.NDArray[Any],
    pattern: Sequence[str],
    *,
    black: float | Sequence[Sequence[float]] | F64 = 0.0,
    white: float | npt.NDArray[Any] | None = None,
    lowest: float | None = None,
    holds_dark: bool = False,
) -> tuple[Plane, ...]:
    """Split a mosaic into the lattices of its filters, without interpolation.

    samples : (rows, cols);  pattern: letters from (0,0) (0,1) …, one string per row, such as ("RG", "GB")
    black   : one level, or a tile of levels from (0, 0);  white: one level, or a tile of the same size

    The two greens of a Bayer array are measured separately, because crosstalk makes them differ.

    >>> [(plane.name, plane.first) for plane in mosaic_planes(np.zeros((4, 4)), ("GR", "BG"))]
    [('R', (0, 1)), ('G1', (0, 0)), ('G2', (1, 1)), ('B', (1, 0))]
    """
    samples = _numbers(samples, "mosaic")
    if isinstance(pattern, str) or not pattern or not pattern[0] or len({len(row) for row in pattern}) != 1:
        given = repr(pattern) if isinstance(pattern, str) else tuple(pattern)[:4]
        raise InvalidValueError(
            f"{given}; give one letter for each, in rows of one length, such as ('RG', 'GB')", key="filters"
        )
    names = channel_names(pattern)
    levels, whites = _levels(black, white)
    rows, cols = (math.lcm(*sizes) for sizes in zip((len(pattern), len(pattern[0])), levels.shape, strict=True))
    if max(rows, cols) > _LONGEST_PERIOD or rows > samples.shape[0] or cols > samples.shape[1]:
        raise InvalidValueError(
            f"they and the black levels repeat every {rows} rows and {cols} columns; {_LONGEST_PERIOD} are the most, "
            f"and the image has {samples.shape[0]} × {samples.shape[1]} photosites",
            key="filters",
        )
    planes = [
        Plane(
            name=names[row % len(pattern)][col % len(pattern[0])],
            samples=samples[row::rows, col::cols],
            first=(row, col),
            step=(rows, cols),
            black=float(levels[row % levels.shape[0], col % levels.shape[1]]),
            white=None if whites is None else float(whites[row % levels.shape[0], col % levels.shape[1]]),
            lowest=lowest,
            holds_dark=holds_dark,
        )
        for row in range(rows)
        for col in range(cols)
    ]
    return tuple(sorted(planes, key=lambda plane: ("RGB".find(plane.name[0]) % 99, plane.name)))


def _levels(black: Any, white: Any) -> tuple[F64, F64 | None]:
    """Return tiles of black and of white levels, of equal size."""
    levels, whites = np.asarray(black, np.float64), None if white is None else np.asarray(white, np.float64)
    for key, given in (("black", levels), ("white", whites)):
        if given is not None and given.ndim != 2 and given.size > 1:
            raise InvalidValueError(
                f"a list of {given.size}; give one level, or rows of levels as the filters have rows", key=key
            )
    levels = np.atleast_2d(levels)
    if whites is None:
        return levels, None
    if whites.size > 1 and whites.shape != levels.shape:
        raise InvalidValueError(f"{whites.shape} levels, and black has {levels.shape}; give as many", key="white")
    return levels, np.broadcast_to(whites, levels.shape)


def places_of(channel: str, pattern: Sequence[str]) -> npt.NDArray[np.bool_]:
    """Return a mask (rows, cols) of a channel's positions in a pattern; G1 is one of the greens, G both.

    >>> places_of("G1", ("RG", "GB")).tolist()
    [[False, True], [False, False]]
    """
    names = channel_names(pattern)
    return np.array([[channel in (name, name.rstrip("0123456789")) for name in row] for row in names])


def channel_names(pattern: Sequence[str]) -> list[list[str]]:
    """Return the channel of every position: its letter, numbered if a Bayer-like array has it twice.

    >>> channel_names(("BG", "GR"))
    [['B', 'G2'], ['G1', 'R']]
    >>> channel_names(("RGGR", "GBBG", "GBBG", "RGGR"))[0]
    ['R', 'G1', 'G1', 'R']
    """
    letters = np.array([list(row) for row in pattern])
    group = len(pattern) // 2
    if letters.shape == (2 * group, 2 * group):
        # Quad Bayer and similar, at any origin: a Bayer array whose every letter is a square.
        for shift in np.ndindex(group, group):
            moved = np.roll(letters, shift, axis=(0, 1))
            small = moved[::group, ::group]
            if np.array_equal(_grown(small, group), moved):
                numbered = _grown(np.array(_numbered(small)), group)
                named: list[list[str]] = np.roll(numbered, (-shift[0], -shift[1]), axis=(0, 1)).tolist()
                return named
    return [list(row) for row in pattern]


def _grown(cell: npt.NDArray[np.str_], group: int) -> npt.NDArray[np.str_]:
    return np.repeat(np.repeat(cell, group, axis=0), group, axis=1)


def _numbered(cell: npt.NDArray[np.str_]) -> list[list[str]]:
    """Return the letters of 2 × 2 positions, repeated ones with a number."""
    names: list[list[str]] = cell.tolist()
    for letter in set(cell.ravel().tolist()):
        # Green in the rows of red is G1, in either row of the pattern.
        places = sorted(np.argwhere(cell == letter).tolist(), key=lambda place: "R" not in cell[place[0]])
        for number, (row, col) in enumerate(places, start=1):
            if len(places) > 1:
                names[row][col] = f"{letter}{number}"
    return names
