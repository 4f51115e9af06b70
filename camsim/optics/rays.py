"""Nodes of a pupil along rays from its middle: rules by radius and along sides, even steps round a circle."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.optics.follow import ROUNDING, nodes_of, not_followed, reached, spare_nodes
from camsim.optics.pupil import Pupil
from camsim.quadrature import GOLDEN

NOTHING = 1e-14  # a coefficient of the phase factor that rounding hides
# On every side of the outline, along which the wavefront is looked at: in steps of the golden section. On even ones
# sin 12θ is nothing, and all that it is multiplied by was.
RAYS: F64 = np.asarray(GOLDEN * np.arange(24) % 1.0, np.float64)
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the way from the obstruction to the outline, likewise
RINGS = 16  # groups, each of as many nodes round as its outermost takes: 1.9 times fewer than if all did
FEW = 1 << 16  # nodes of a circle that are made all at once: groups of rings one by one take up to four times as long
MOST_POINTS = 1 << 13  # round a circle


class OverPupil(Protocol):
    """A lens of one opening, and the path difference over it."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102

    def __hash__(self) -> int: ...

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102


class Turns(NamedTuple):
    """By how much waves turn on half of the diameter along x and along y, radians: all of a rectangle's.

    x, y : of its corners, from its middle;  middle_rad: what the wave in its middle turns, along x and along y
    """

    x: float
    y: float
    middle_rad: tuple[float, float] = (0.0, 0.0)

    def along(self, x: F64, y: F64) -> F64:
        """Return how much any of them turns at most on the way (x, y)."""
        most: F64 = np.abs(self.middle_rad[0] * x + self.middle_rad[1] * y) + self.x * np.abs(x) + self.y * np.abs(y)
        return most

    @property
    def most(self) -> tuple[float, float]:
        """What any of them turns at most along x, and along y."""
        return abs(self.middle_rad[0]) + self.x, abs(self.middle_rad[1]) + self.y

    @property
    def largest(self) -> float:
        """What any of them turns on half of the diameter in any direction."""
        return math.hypot(*self.most)


class Rays(NamedTuple):
    """A polar rule over an opening: rings of an even number of nodes, or of a number for each side.

    along, round_about : nodes that the wavefront takes besides waves along a radius, and along a side; round a circle
                         the degree of its phase factor
    turns : of the waves besides
    """

    pupil: Pupil
    along: int
    round_about: int
    turns: Turns

    @classmethod
    def of(cls, lens: OverPupil, wavelength_nm: float, turns: Turns) -> Rays:
        """Return the rule for a lens, and for waves."""
        round_about = _degree_round(lens, wavelength_nm) if lens.pupil.sides == 1 else _spare(lens, wavelength_nm, True)
        return cls(lens.pupil, _spare(lens, wavelength_nm, False), round_about, turns)

    @property
    def total(self) -> float:
        """How many nodes there are."""
        return float(sum((rings.stop - rings.start) * sum(sides) for rings, sides in self._groups))

    def parts(self, at_once: int, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights, about ``at_once`` nodes at a time; ``half``: of two that are opposite only one."""

        if self.pupil.sides == 1 and self.total <= min(FEW, at_once):
            each_ring = [np.full(rings.stop - rings.start, round_it) for rings, (round_it,) in self._groups]
            yield self.pupil.rings(self._radial, np.concatenate(each_ring), half=half)
            return

        def each() -> Iterator[tuple[F64, F64, F64]]:
            for rings, sides in self._groups:
                most = max(at_once // sum(sides), 1)
                for first in range(rings.start, rings.stop, most):
                    yield self.pupil.rule(self._radial, sides, slice(first, min(first + most, rings.stop)), half=half)

        yield from joined(each(), at_once)

    @property
    def _radial(self) -> int:
        """Nodes along a radius."""
        pupil, turns = self.pupil, self.turns
        farthest = float(turns.along(*pupil.corners.T).max()) if pupil.sides > 1 else turns.largest
        open_part = 1.0 - pupil.obstruction / pupil.outer_radius
        return nodes_of(farthest * open_part, self.along)

    @property
    def _groups(self) -> tuple[tuple[slice, list[int]], ...]:
        """Rings from the inside out, and how many nodes each has on each side: as its group's outermost takes."""
        return _groups_of(self)


@functools.lru_cache(maxsize=256)
def _groups_of(rays: Rays) -> tuple[tuple[slice, list[int]], ...]:
    """Return them: prices ask for the same rule again and again."""
    pupil, turns = rays.pupil, rays.turns
    inner, groups = pupil.obstruction, []
    largest, of_sides = turns.largest, []
    if pupil.sides > 1:
        ways = np.roll(pupil.corners, -1, axis=0) - pupil.corners
        of_sides = [float(turns.along(dx, dy)) for dx, dy in ways]
    for rings, share in _rings(rays._radial):
        hole = (1.0 - share) * inner * largest
        if pupil.sides == 1:
            sides = [2 * math.ceil(0.53 * (share * largest + hole) + 32.0 + 0.5 * rays.round_about)]
        else:
            # A ring is so much of its outline, and the rest a circle: in the middle of a side a ray turns fastest.
            of_hole = hole * pupil.side_length / pupil.inner_radius
            sides = [nodes_of(share * turned + of_hole, rays.round_about) for turned in of_sides]
        groups.append((rings, sides))
    return tuple(groups)


@functools.lru_cache(maxsize=256)
def _rings(radial: int) -> tuple[tuple[slice, float], ...]:
    """Return the groups of so many rings, and how much of the way from the obstruction, or a little less, each goes."""
    ends = sorted({round(radial * part / RINGS) for part in range(RINGS + 1)})
    return tuple((slice(first, stop), reached(radial, stop)) for first, stop in pairwise(ends))


def joined(parts: Iterable[tuple[F64, F64, F64]], at_once: int) -> Iterator[tuple[F64, F64, F64]]:
    """Yield x, y and weights of parts in a row together, about ``at_once`` nodes at a time.

    Each that is yielded takes a transform of its own where the lattice is small.
    """
    held: list[tuple[F64, F64, F64]] = []
    count = 0
    for part in parts:
        if held and count + part[0].size > at_once:
            joint, held, count = [_together(held)], [], 0
            yield joint.pop()  # and nothing is kept of it
        held.append(part)
        count += part[0].size
    if held:
        yield _together(held)


def _together(parts: list[tuple[F64, F64, F64]]) -> tuple[F64, F64, F64]:
    x, y, weights = (np.concatenate(each) for each in zip(*parts, strict=True))
    return x, y, weights


@functools.lru_cache(maxsize=256)
def _spare(lens: OverPupil, wavelength_nm: float, sides: bool) -> int:
    """Return how many nodes the wavefront takes besides waves: along radii, or along what rings have of ``sides``."""
    inner = lens.pupil.obstruction

    def waves(angle: F64, edge: F64, share: F64) -> F64:
        radius = inner + share * (edge - inner)
        return lens.waves(radius * np.cos(angle), radius * np.sin(angle), wavelength_nm)

    def along_radii(t: F64) -> F64:
        angle, edge = (a.reshape(1, -1, 1) for a in lens.pupil.rays(RAYS))
        return waves(angle, edge, t)

    def along_sides(t: F64) -> F64:
        angle, edge = lens.pupil.rays(t)
        return waves(angle, edge, np.array(SHARES)[:, None, None]).reshape(1, -1, t.size)

    along, lines = (along_sides, "a side") if sides else (along_radii, "a radius")
    return spare_nodes(along, wavelength_nm, lines)[0]


@functools.lru_cache(maxsize=256)
def _degree_round(lens: OverPupil, wavelength_nm: float) -> int:
    """Return the degree of exp(2πiW) round a circle, read off its harmonics, of as many points as it takes to end."""
    inner, points = lens.pupil.obstruction, 64
    radius = inner + np.array(SHARES)[:, None] * (1.0 - inner)
    while points <= MOST_POINTS:
        angle = 2.0 * np.pi * np.arange(points) / points
        waves = lens.waves(radius * np.cos(angle), radius * np.sin(angle), wavelength_nm)
        hidden = max(NOTHING, 2.0 * math.pi * ROUNDING * float(np.abs(waves).max()))
        spectrum = np.abs(scipy.fft.fft(np.exp(2j * np.pi * waves), axis=-1)).max(axis=0) / points
        # The middle one as well: of cos 16θ the second harmonic is there, of 64 points, and others look like the first.
        matter = np.flatnonzero(np.maximum(spectrum, np.roll(spectrum[::-1], 1))[: points // 2 + 1] > hidden)
        degree = int(matter[-1]) if matter.size else 0
        if degree < 0.375 * points:
            return degree
        points *= 2
    raise not_followed(wavelength_nm, "round the pupil", MOST_POINTS)
