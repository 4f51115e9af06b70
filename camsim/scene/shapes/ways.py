"""The centre of a line: straight and round pieces, cut into dashes."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

DOT = 1e-9  # of a line's width: a dash of zero length, which still has a direction


class Way(NamedTuple):
    """A piece of the centre of a line: straight, or an arc that turns by ``bend_rad``.

    place : consecutive for pieces of one curve
    """

    start: complex
    end: complex
    bend_rad: float
    place: int = 0

    @property
    def out(self) -> complex:
        """Direction (unit vector) at the start of the piece."""
        return unit(self.end - self.start) * turn(-0.5 * self.bend_rad)

    @property
    def into(self) -> complex:
        """Direction (unit vector) at the end of the piece."""
        return unit(self.end - self.start) * turn(0.5 * self.bend_rad)

    @property
    def radius(self) -> float:
        """Signed radius, positive if its centre is on the left (cross product above 0)."""
        return math.inf if self.bend_rad == 0.0 else 0.5 * abs(self.end - self.start) / math.sin(0.5 * self.bend_rad)

    @property
    def length(self) -> float:
        """Length of the piece."""
        return abs(self.end - self.start) if self.bend_rad == 0.0 else abs(self.radius * self.bend_rad)

    def back(self) -> Way:
        """Return the piece, run through in reverse."""
        return Way(self.end, self.start, -self.bend_rad, -self.place)

    def at(self, t: float) -> complex:
        """Return the point at a fraction of the piece's length; exact at both ends."""
        if t in (0.0, 1.0):
            return self.end if t else self.start
        if self.bend_rad == 0.0:
            return self.start + t * (self.end - self.start)
        centre = self.start + 1j * self.radius * self.out
        return centre + (self.start - centre) * turn(self.bend_rad * t)

    def part(self, t0: float, t1: float) -> Way:
        """Return the part of the piece between two fractions of its length."""
        return Way(self.at(t0), self.at(t1), self.bend_rad * (t1 - t0), self.place)


def turn(angle: float) -> complex:
    """Return the unit vector of an angle."""
    return complex(math.cos(angle), math.sin(angle))


def unit(vector: complex) -> complex:
    """Return the unit vector of a vector."""
    return vector / abs(vector)


def dashes_of(
    ways: Sequence[Way], closed: bool, pattern: Sequence[float], offset: float, dot: float
) -> Iterator[tuple[list[Way], bool]]:
    """Yield the dashes of an outline, each as pieces, and whether it is closed.

    pattern : an even number of lengths of dash, gap, dash …, not all 0;  offset: where in it the outline starts
    dot     : length used for dashes of zero length

    A dash that reaches the end of a closed outline is joined with the one at its start.
    """
    until = list(itertools.accumulate((way.length for way in ways), initial=0.0))
    total, period = until[-1], sum(pattern)
    offset %= period
    edges = [*itertools.accumulate(pattern, initial=0.0)]
    spans = []
    for round_ in range(math.ceil((offset + total) / period) + 1):
        for low, high in zip(edges[0:-1:2], edges[1::2], strict=True):
            begin, end = round_ * period + low - offset, round_ * period + high - offset
            if low == high and 0.0 <= begin <= total:
                begin = min(begin, max(0.0, total - dot))
                spans.append((begin, begin + dot))
            elif end > 0.0 and begin < total:
                spans.append((max(begin, 0.0), min(end, total)))
    if closed and spans and spans[0][0] == 0.0 and spans[-1][1] == total:
        if len(spans) == 1:
            yield list(ways), True
            return
        first, last = spans.pop(0), spans.pop()
        yield [*_between(ways, until, *last), *_between(ways, until, *first)], False
    for span in spans:
        if dash := _between(ways, until, *span):
            yield dash, False


def _between(ways: Sequence[Way], until: Sequence[float], begin: float, end: float) -> list[Way]:
    """Return the pieces from one distance to another."""
    found = []
    for number in range(max(0, bisect.bisect_right(until, begin) - 1), len(ways)):
        if until[number] >= end:
            break
        size = until[number + 1] - until[number]
        if size == 0.0:  # too short to change the sum
            continue
        low, high = max(0.0, (begin - until[number]) / size), min(1.0, (end - until[number]) / size)
        if (way := ways[number].part(low, high)).start != way.end:
            found.append(way)
    return found
