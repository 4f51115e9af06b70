"""Thick lines: straight ones and curves, with joins and caps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.core.typed import NonNegative, Number, Positive, Several, refusal, validate
from camsim.scene.arcs import Fineness, arcs_of
from camsim.scene.curves import STRAIGHT, Curves, Pen
from camsim.scene.shapes.path import Drawn, Segments
from camsim.scene.shapes.ways import DOT, Way, dashes_of, unit
from camsim.spectra.curve import NumberOrCurve, Reflectance

Cap = Literal["butt", "round", "square"]
Join = Literal["miter", "round", "bevel"]
MiterLimit = Annotated[float, Ge(1), Le(1e6)]

Outline: TypeAlias = tuple[tuple[float, float], list[Way], bool]
"""Start, pieces (none for zero length), and whether it is closed."""

FOLLOWED = 1e-7  # of its width: accuracy of arcs along a bent line's centre
NO_WAVE = 1e-3  # of that distance: so short that only distance matters
MOST_DASHES = 200_000
SMOOTH = 1e-7  # radians: largest change of direction that is not a corner


@dataclass(frozen=True, slots=True, kw_only=True)
class Line(Drawn):
    """A line of some width along a path.

    segments_um : as for a Path; each outline may be open, and is closed by ("close",)
    width_um    : width of the line, half of it on either side of the path
    cap         : shape of open ends: cut off square, a half disc, or half a width longer; a path without length shows
                  its caps alone: nothing, a disc, or an upright square
    join        : shape of corners: sides extended until they meet, a disc, or cut off; where a curve turns back, a disc
    miter_limit : largest length of a miter in widths; longer ones are cut off, as in SVG
    dashes_um   : lengths of dash, gap, dash … along each outline, repeated; an odd number is doubled, as in SVG
    dash_offset_um : where in this pattern each outline begins

    >>> Line(segments_um=[("move", 0, 0), ("line", 30, 0)], width_um=4.0, cap="round", reflectance=0.1).segments_um
    (('move', 0.0, 0.0), ('line', 30.0, 0.0))
    """

    segments_um: Segments
    width_um: Positive
    cap: Cap = "butt"
    join: Join = "miter"
    miter_limit: MiterLimit = 4.0
    dashes_um: Several[NonNegative] = ()
    dash_offset_um: float = 0.0
    reflectance: Reflectance
    _curves: Curves = field(init=False, repr=False, compare=False)

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            segments_um: Segments,
            width_um: Number,
            cap: Cap = "butt",
            join: Join = "miter",
            miter_limit: Number = 4.0,
            dashes_um: Several[Number] = (),
            dash_offset_um: Number = 0.0,
            reflectance: NumberOrCurve,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        pen = Pen()
        for start, ways, closed in self._drawn():
            if ways:
                _Stroke(self, ways, closed).draw(pen)
            else:
                self._dot(pen, start)
        self._keep(pen, "a line")

    def _drawn(self) -> Iterator[Outline]:
        """Yield each outline, or its dashes; zero length has none, as in SVG."""
        pattern = tuple(self.dashes_um) * (1 + len(self.dashes_um) % 2)
        if sum(pattern) == 0.0:  # as in SVG
            yield from _parts(self.segments_um, self.width_um)
            return
        left = float(MOST_DASHES)
        for start, ways, closed in _parts(self.segments_um, self.width_um):
            left -= sum(way.length for way in ways) / sum(pattern) * (len(pattern) // 2)
            if not left >= 0.0:
                raise refusal(self, "dashes_um", f"makes more than {MOST_DASHES} dashes; give longer ones")
            if ways:
                for dash in dashes_of(ways, closed, pattern, self.dash_offset_um, DOT * self.width_um):
                    yield start, *dash

    def _dot(self, pen: Pen, at: tuple[float, float]) -> None:
        """Draw the caps of an outline of zero length, directed to the right."""
        (x, y), half = at, 0.5 * self.width_um
        if self.cap == "butt":
            return
        pen.move(x - half, y - half if self.cap == "square" else y)
        if self.cap == "square":
            for right, down in ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)):
                pen.line(x + right * half, y + down * half)
        else:
            for side in (1.0, -1.0):
                pen.arc(half, half, 0.0, False, True, x + side * half, y)
        pen.close()


def _parts(segments: Iterable[Any], width_um: float) -> Iterator[Outline]:
    """Yield each outline with a drawing command, even of zero length."""
    groups: list[tuple[list[tuple[Any, ...]], bool]] = []
    for segment in segments:
        if segment[0] == "move" or not groups:
            groups.append(([], False))
        elif groups[-1][1] and segment[0] == "close":
            continue
        elif groups[-1][1]:  # continues at the start of the closed one
            groups.append(([("move", *groups[-1][0][0][1:])], False))
        if segment[0] == "close":
            groups[-1] = (groups[-1][0], True)
        else:
            groups[-1][0].append(segment)
    for drawn, closed in groups:
        if len(drawn) == 1 and not closed:
            continue
        pen = Pen()
        for word, *numbers in drawn:
            getattr(pen, word)(*numbers)
        # The pen's closing piece is removed again.
        more = 0 if closed or pen.place == pen.start else 1
        curves = pen.curves()
        ways = _ways(curves, width_um)
        yield pen.start, ways[: len(ways) - more], closed


def _ways(curves: Curves, width_um: float) -> list[Way]:
    bent = np.flatnonzero(curves.kind != STRAIGHT)
    fine = FOLLOWED * width_um
    # Approximated to a distance, for any optics.
    arcs = arcs_of(curves.some(bent), Fineness(NO_WAVE * fine, 2.0 / NO_WAVE)) if bent.size else None
    ways: list[Way] = []
    place = 0
    for number, ends in enumerate(curves.points[:, [0, 3]].tolist()):
        parts: Iterable[tuple[complex, complex, float]] = [(complex(*ends[0]), complex(*ends[1]), 0.0)]
        if arcs is not None and curves.kind[number] != STRAIGHT:
            parts = zip(*(column[bent[arcs.owner] == number].tolist() for column in arcs[1:]), strict=True)
        place += 1  # a step of two marks a new curve
        ways += [Way(*part, place := place + 1) for part in parts]
    return ways


class _Stroke:
    """One outline of a line: forward along its left side, back along its right side."""

    def __init__(self, line: Line, ways: list[Way], closed: bool) -> None:
        self.line, self.half, self.ways, self.closed = line, 0.5 * line.width_um, ways, closed

    def draw(self, pen: Pen) -> None:
        """Draw the stroke; where it overlaps itself, the winding number is 2."""
        back = [way.back() for way in reversed(self.ways)]
        if self.closed:
            for ways in (self.ways, back):
                self._begin(pen, ways[0])
                self._side(pen, ways)
                self._corner(pen, ways[-1], ways[0])
                pen.close()
        else:
            self._begin(pen, self.ways[0])
            self._side(pen, self.ways)
            self._cap(pen, self.ways[-1])
            self._side(pen, back)
            self._cap(pen, back[-1])
            pen.close()
        for way in self.ways:
            self._beyond_centre(pen, way)

    def _begin(self, pen: Pen, way: Way) -> None:
        pen.move(*_xy(way.start - 1j * self.half * way.out))

    def _side(self, pen: Pen, ways: Sequence[Way]) -> None:
        """Draw the right side (cross product below 0) of pieces and of the corners between them."""
        for number, way in enumerate(ways):
            radius = way.radius + self.half  # radius of the right side
            end = way.end - 1j * self.half * way.into
            if way.bend_rad == 0.0:
                pen.line(*_xy(end))
            elif way.radius > 0.0 or -way.radius > self.half:
                pen.arc(abs(radius), abs(radius), 0.0, abs(way.bend_rad) > math.pi, way.bend_rad > 0.0, *_xy(end))
            else:  # half width exceeds the radius: its side is beyond the centre
                pen.line(*_xy(way.start + 1j * way.radius * way.out))
                pen.line(*_xy(end))
            if number + 1 < len(ways):
                self._corner(pen, way, ways[number + 1])

    def _corner(self, pen: Pen, before: Way, after: Way) -> None:
        turn = math.atan2((before.into.conjugate() * after.out).imag, (before.into.conjugate() * after.out).real)
        there = after.start - 1j * self.half * after.out
        if abs(turn) <= SMOOTH:
            pen.line(*_xy(there))
        elif turn < 0.0:
            # The inner side passes through the corner, to avoid negative winding.
            pen.line(*_xy(after.start))
            pen.line(*_xy(there))
        elif self.line.join == "round" or after.place == before.place + 1:  # a curve has no corners
            pen.arc(self.half, self.half, 0.0, False, True, *_xy(there))
        else:
            longer = 1.0 / max(math.cos(0.5 * turn), 1e-9)
            if self.line.join == "miter" and longer <= self.line.miter_limit:
                pen.line(*_xy(after.start - 1j * self.half * longer * unit(before.into + after.out)))
            pen.line(*_xy(there))

    def _cap(self, pen: Pen, way: Way) -> None:
        there = way.end + 1j * self.half * way.into
        if self.line.cap == "round":
            pen.arc(self.half, self.half, 0.0, False, True, *_xy(way.end + self.half * way.into))
            pen.arc(self.half, self.half, 0.0, False, True, *_xy(there))
            return
        if self.line.cap == "square":
            pen.line(*_xy(way.end + self.half * way.into * (1.0 - 1.0j)))
            pen.line(*_xy(way.end + self.half * way.into * (1.0 + 1.0j)))
        pen.line(*_xy(there))

    def _beyond_centre(self, pen: Pen, way: Way) -> None:
        """Draw the area that a piece with a radius below its half width sweeps beyond its centre."""
        rest = self.half - abs(way.radius)
        if way.bend_rad == 0.0 or rest <= 0.0:
            return
        centre = way.start + 1j * way.radius * way.out
        side = 1.0 if way.bend_rad > 0.0 else -1.0
        first, last = centre + 1j * side * rest * way.out, centre + 1j * side * rest * way.into
        if way.bend_rad < 0.0:
            first, last = last, first
        pen.move(*_xy(centre))
        pen.line(*_xy(first))
        pen.arc(rest, rest, 0.0, abs(way.bend_rad) > math.pi, True, *_xy(last))
        pen.close()


def _xy(place: complex) -> tuple[float, float]:
    return place.real, place.imag
