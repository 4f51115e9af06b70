"""Nodes of a pupil along rays from its middle: rules by radius and along sides, even steps round a circle."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64, I64
from camsim.optics.follow import ROUNDING, Turns, from_0, nodes_before, nodes_of, not_followed, spare_nodes
from camsim.optics.panels import OverPupil, PanelRule, joined, panels_of
from camsim.optics.pupil import Pupil
from camsim.quadrature import GOLDEN

NOTHING = 1e-14  # a coefficient of the phase factor that rounding hides
# Round a circle, along which the wavefront is looked at: in steps of the golden section. On even ones
# sin 12θ is nothing, and all that it is multiplied by was.
RAYS: F64 = np.asarray(GOLDEN * np.arange(96) % 1.0, np.float64)
MOST_ALONG = 8000  # nodes that a wavefront takes along a radius
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the way from the obstruction to the rim, likewise
RINGS = 16  # groups, each of as many nodes round as its outermost takes: 1.9 times fewer than if all did
FEW = 1 << 16  # nodes of a circle that are made all at once: groups of rings one by one take up to four times as long
MOST_POINTS = 1 << 13  # round a circle


class _Side(NamedTuple):
    """The part of a polygon, less the hole in its middle, that is seen from the middle through one side.

    normal_rad, distance, length : of the side;  hole: radius;  first_half: 1 where the opposite one does not count
    """

    normal_rad: float
    distance: float
    length: float
    hole: float
    first_half: float

    @property
    def bent(self) -> bool:
        """Rays end on a straight side."""
        return False

    def at(self, u: F64, t: F64) -> tuple[F64, F64, F64]:
        """Return x, y and area: ``u`` goes from the hole to the side, ``t`` along this."""
        along = self.length * (t - 0.5)
        edge = np.hypot(self.distance, along)
        angle = self.normal_rad + np.arctan(along / self.distance)
        way = edge - self.hole
        radius = self.hole + u * way
        area = radius * way * (self.length * self.distance / edge**2)
        return radius * np.cos(angle), radius * np.sin(angle), area


class Rays(NamedTuple):
    """A polar rule over a round opening: rings of an even number of nodes.

    along       : nodes that the wavefront takes besides waves along a radius
    round_about : round a circle the degree of its phase factor
    turns       : of the waves besides
    """

    pupil: Pupil
    along: int
    round_about: int
    turns: Turns

    @property
    def total(self) -> float:
        """How many nodes there are."""
        return float(sum((rings.stop - rings.start) * round_it for rings, round_it in self._groups))

    def parts(self, at_once: int, half: bool = False) -> Iterator[tuple[F64, F64, F64]]:
        """Yield x, y and weights, about ``at_once`` nodes at a time; ``half``: of two that are opposite only one."""

        if self.total <= min(FEW, at_once):
            each_ring = [np.full(rings.stop - rings.start, round_it) for rings, round_it in self._groups]
            yield self.pupil.rings(self._radial, np.concatenate(each_ring), half=half)
            return

        def each() -> Iterator[tuple[F64, F64, F64]]:
            for rings, round_it in self._groups:
                most = max(at_once // round_it, 1)
                for first in range(rings.start, rings.stop, most):
                    count = min(most, rings.stop - first)
                    yield self.pupil.rings(self._radial, np.full(count, round_it), first, half=half)

        yield from joined(each(), at_once)

    @property
    def _radial(self) -> int:
        """Nodes along a radius."""
        return int(nodes_of(self.turns.largest * (1.0 - self.pupil.obstruction), self.along))

    @property
    def _groups(self) -> tuple[tuple[slice, int], ...]:
        """Rings from the inside out, and how many nodes each has: as its group's outermost takes."""
        return _groups_of(self)


@functools.lru_cache(maxsize=256)
def _groups_of(rays: Rays) -> tuple[tuple[slice, int], ...]:
    """Return them: prices ask for the same rule again and again."""
    inner, radial, turned = rays.pupil.obstruction, rays._radial, rays.turns.largest
    ends = np.arange(RINGS + 1) / RINGS
    groups = []
    for (first, stop), share in zip(pairwise(nodes_before(radial, ends).tolist()), ends[1:].tolist(), strict=True):
        if first < stop:
            outermost = (share + (1.0 - share) * inner) * turned
            groups.append((slice(first, stop), 2 * math.ceil(0.53 * outermost + 32.0 + 0.5 * rays.round_about)))
    return tuple(groups)


def rays_of(lens: OverPupil, wavelength_nm: float, turns: Turns) -> PanelRule | Rays:
    """Return the rule for a lens, and for waves."""
    if lens.pupil.sides == 1:
        return Rays(lens.pupil, _spare(lens, wavelength_nm), _degree_round(lens, wavelength_nm), turns)
    return PanelRule(panels_of(lens, wavelength_nm, sides_of(lens.pupil)), turns)


@functools.lru_cache(maxsize=64)
def sides_of(pupil: Pupil) -> tuple[_Side, ...]:
    """Return a polygon as what is seen through its sides."""
    length, count = pupil.side_length, pupil.sides
    return tuple(
        _Side(normal_rad, pupil.inner_radius, length, pupil.obstruction, float(number < count // 2))
        for number, normal_rad in enumerate(pupil.normals())
    )


def places_over(pupil: Pupil, across: int) -> tuple[F64, F64]:
    """Return places (x, y) all over an opening: so many along a radius, and round a circle or along each side."""
    if pupil.sides == 1:
        x, y, _ = pupil.rings(across, np.full(across, across))
        return x, y
    t = from_0(across)[0]
    x, y = np.stack([side.at(t[:, None], t)[:2] for side in sides_of(pupil)], axis=1).reshape(2, -1)
    return x, y


@functools.lru_cache(maxsize=256)
def _spare(lens: OverPupil, wavelength_nm: float) -> int:
    """Return how many nodes the wavefront takes besides waves along radii."""
    inner, angle = lens.pupil.obstruction, 2.0 * np.pi * RAYS.reshape(1, -1, 1)

    def waves(t: F64, _: I64) -> F64:
        radius = inner + t * (1.0 - inner)
        return lens.waves(radius * np.cos(angle), radius * np.sin(angle), wavelength_nm)

    [spare] = spare_nodes(waves, np.ones(1), MOST_ALONG).tolist()
    if not spare:
        raise not_followed(wavelength_nm, "along a radius of the pupil", f"{MOST_ALONG} points")
    return int(spare)


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
    raise not_followed(wavelength_nm, "round the pupil", f"{MOST_POINTS} points")
