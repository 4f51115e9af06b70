"""Samples of a lens of revolution's transfers along its radius, and how many of them follow it."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.optics.placed import Revolves
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.across.hardest import hardest, heights_within, waves_at
from camsim.rendering.across.overlap import Terms, overlaps
from camsim.rendering.across.unfollowed import unfollowed

RULES = (8, 12, 16, 20, 24, 28, 32, 40, 48, 64, 96, 128, 160, 208, 256, 320, 400, 512)  # of the overlap, either way
SERIES = (32, 64, 128, 256, 512)  # points on which a series' end is looked for
SHIFTS = np.array([0.03, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95])  # where nodes are counted
ANGLES = 0.5 * math.pi * np.linspace(0.0, 1.0, 13)  # a term cos mθ is steepest in m directions: of all small m
FEW = ANGLES[::3]  # of what is compared at many places
TRIED, FOLLOWED = 5, 2  # places, and wavelengths, at which the others' nodes are counted; and how far series go
MARGIN = 2  # harmonics more
TURNS = 8  # times m of terms cos mθ: so many harmonics are looked at, as of a single one each 2m-th is something
GROUPS = 8  # of wavelengths, that have a rule in common
COLOURS = (12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 56, 64, 80, 96, 128, 192, 256)  # nodes of a spectrum
EACH_NODE, EACH_PHASE = 2e-8, 2e-9  # seconds: of a polynomial at a node, and of a wavefront there


class TooLong(Exception):
    """It takes longer to find out how many samples there are than it may."""


class Sampler:
    """What samples monochromatic transfers along the radius, less the perfect one's."""

    def __init__(
        self, lens: Revolves, wavelength_nm: F64, weights: F64, radii_um: tuple[float, float], allowed: float
    ) -> None:
        self.lens, self.wavelength_nm, self.weights, self.allowed = lens, wavelength_nm, weights, allowed
        self.within_um = radii_um
        self._left_seconds = math.inf
        self.zernike = lens.at(lens.height_um[-1], 0.0).zernike
        self.terms = Terms.of(self.zernike)
        self.order = int(self.terms.order.max(initial=0))
        self.radii_um = np.array([*radii_um, *heights_within(lens, radii_um)])
        self.rules = self._rules(wavelength_nm, allowed)

    @contextlib.contextmanager
    def within(self, seconds: float) -> Iterator[None]:
        """Raise ``TooLong`` when what is sampled meanwhile is expected to take longer, of one core."""
        self._left_seconds = seconds
        try:
            yield
        finally:
            self._left_seconds = math.inf

    def hardest(self, radius_um: F64, wavelength_nm: F64) -> I64:
        """Return numbers of the radii (n,) at which wavefronts are the hardest to follow, and of the last one."""
        waves = waves_at(self.lens, radius_um, wavelength_nm[:1])
        found: I64 = np.union1d(hardest(self.zernike, waves, FOLLOWED), [radius_um.size - 1])
        return found

    def _rules(self, wavelength_nm: F64, allowed: float) -> I64:
        """Return how many nodes across and along (2, n) settle the overlaps at each of ``SHIFTS``."""
        some_nm = wavelength_nm[np.unique(np.linspace(0, wavelength_nm.size - 1, TRIED).round().astype(int))]
        waves = waves_at(self.lens, self.radii_um, some_nm)
        waves = np.ascontiguousarray(waves[:, hardest(self.zernike, waves, TRIED)])
        rules, allowed = np.empty((2, SHIFTS.size), np.int64), 0.5 * allowed
        for k, shift in enumerate(SHIFTS):
            own = np.array([shift])
            right = overlaps(self.terms, waves, own, ANGLES, (RULES[0], RULES[0]))
            for rules[0, k], nodes in pairwise(RULES):
                before, right = right, overlaps(self.terms, waves, own, ANGLES, (nodes, nodes))
                if float(np.abs(right - before).max()) <= allowed:
                    break
            else:
                raise unfollowed(f"{RULES[-1]} × {RULES[-1]} nodes of their overlaps")
            for rules[1, k] in RULES:
                found = overlaps(self.terms, waves, own, ANGLES, (int(rules[0, k]), int(rules[1, k])))
                if float(np.abs(found - right).max()) <= 2.0 * allowed:
                    break
        return rules

    def _overlaps(self, waves: F64, shift: F64, angle_rad: F64, rules: I64) -> C128:
        """Return transfers (wavefronts, shifts, angles), each by as many nodes as its shift takes."""
        out = np.empty((waves.shape[1], shift.size, angle_rad.size), complex)
        nodes = _nodes(rules, shift)
        self._left_seconds -= self._taking(nodes, waves.shape[1], angle_rad.size)
        if self._left_seconds < 0.0:
            raise TooLong
        for across, along in np.unique(nodes, axis=1).T:
            here = (nodes[0] == across) & (nodes[1] == along)
            out[:, here] = overlaps(self.terms, waves, shift[here], angle_rad, (int(across), int(along)))
        return out

    def colours(self, radius_um: F64) -> tuple[F64, F64]:
        """Return wavelengths (n,) whose transfers stand for all, and what each of all takes of them (all, n)."""
        nm, count = self.wavelength_nm, self.wavelength_nm.size
        middle, half = 0.5 * (nm[0] + nm[-1]), 0.5 * (nm[-1] - nm[0])
        right = None
        for nodes in COLOURS:
            if count <= nodes:
                break
            if right is None:
                right = np.einsum("sj,rjn->srn", self.weights, self.probed(radius_um, nm))
            x = chebyshev(nodes)
            own = interpolation(x, (nm - middle) / half)
            found = np.einsum(
                "sk,rkn->srn", np.einsum("sj,jk->sk", self.weights, own), self.probed(radius_um, middle + half * x)
            )
            if float(np.abs(found - right).max()) <= self.allowed:
                return middle + half * x, own
        return nm, np.eye(count)

    def probed(self, radius_um: F64, wavelength_nm: F64) -> C128:
        """Return a few samples (radii, wavelengths, n) of transfers."""
        found = self._overlaps(waves_at(self.lens, radius_um, wavelength_nm), SHIFTS, FEW, self.rules)
        return found.reshape(radius_um.size, wavelength_nm.size, -1)

    def series(self, radius_um: F64, wavelength_nm: F64, light: F64) -> tuple[int, int]:
        """Return how many points along √(1 − ν), and half round, follow the transfers at any of some radii.

        light : of each wavelength, the most that a set takes
        """
        waves = waves_at(self.lens, radius_um, wavelength_nm)
        ends = []
        for along in (True, False):
            for count in SERIES if along else [own for own in SERIES if own >= TURNS * self.order]:
                shift = _shifts(count) if along else SHIFTS
                angle = FEW if along else math.pi * np.arange(count) / count
                found = self._overlaps(waves, shift, angle, self.rules)
                end = max(_end(own, along, light, self.allowed) for own in np.split(found, radius_um.size))
                if end <= 0.75 * count:
                    break
            else:
                raise unfollowed(f"series of {SERIES[-1]} terms")
            ends.append(end + MARGIN)
        return ends[0], ends[1]

    def ruled(self, wavelength_nm: F64, light: F64) -> list[tuple[slice, I64]]:
        """Return groups of wavelengths, each with its nodes: those of little light, often the steepest, take few."""
        parts = np.array_split(np.arange(wavelength_nm.size), min(GROUPS, wavelength_nm.size))
        allowed = [self.allowed / max(GROUPS * float(light[part].sum()), 1e-300) for part in parts]
        return [
            (slice(int(part[0]), int(part[-1]) + 1), self._rules(wavelength_nm[part], own))
            for part, own in zip(parts, allowed, strict=True)
        ]

    def seconds(self, radii: int, ruled: list[tuple[slice, I64]], shifts: int, angles: int) -> float:
        """Return what ``sampled`` takes of one core."""
        shift, seconds = _shifts(shifts), 0.0
        for part, rules in ruled:
            seconds += self._taking(_nodes(rules, shift), radii * (part.stop - part.start) + 1, angles // 2 + 1)
        return seconds

    def _taking(self, nodes: I64, wavefronts: int, angles: int) -> float:
        """Return what overlaps take of one core, by nodes across and along (2, shifts)."""
        each = EACH_NODE * self.terms.order.size + EACH_PHASE * wavefronts
        return each * float(np.sum(nodes[0] // 2 * nodes[1])) * angles

    def sampled(
        self, radius_um: F64, wavelength_nm: F64, ruled: list[tuple[slice, I64]], shifts: int, angles: int
    ) -> C128:
        """Return (radii, wavelengths · shifts, angles) of T − Airy, a quarter of a circle of angles."""
        shift, angle = _shifts(shifts), math.pi * np.arange(angles // 2 + 1) / angles
        out = np.empty((radius_um.size, wavelength_nm.size, shifts, angle.size), complex)
        for part, rules in ruled:
            waves = waves_at(self.lens, radius_um, wavelength_nm[part])
            # Less the perfect one's by the same nodes: what they lose of the pupil, both do.
            found = self._overlaps(np.append(waves, np.zeros((len(waves), 1)), axis=1), shift, angle, rules)
            out[:, part] = (found[:-1] - found[-1]).reshape(radius_um.size, -1, shifts, angle.size)
        return out.reshape(radius_um.size, -1, angle.size)


def _shifts(count: int) -> F64:
    """Return shifts ν that are Chebyshev's nodes in √(1 − ν)."""
    shifts: F64 = 1.0 - (0.5 * (1.0 + chebyshev(count))) ** 2
    return shifts


def _nodes(rules: I64, shift: F64) -> I64:
    """Return nodes across and along (2, shifts): as many as either of ``SHIFTS`` about a shift takes."""
    after = np.clip(np.searchsorted(SHIFTS, shift), 0, SHIFTS.size - 1)
    return np.maximum(rules[:, after], rules[:, np.maximum(after - 1, 0)])


def _end(found: C128, along: bool, light: F64, allowed: float) -> int:
    """Return how many terms a series of transfers (wavelengths, shifts, angles) has along √(1 − ν), or round about."""
    count = found.shape[1 if along else 2]
    if along:
        each = np.abs(scipy.fft.dct(found.real, axis=1)) + np.abs(scipy.fft.dct(found.imag, axis=1))
        size = np.einsum("k,knd->nd", light, each).max(axis=1) / count
    else:
        each = np.abs(scipy.fft.fft(np.concatenate([found, found.conj()], axis=2), axis=2))
        both = np.einsum("k,kdn->dn", light, each).max(axis=0)
        size = np.maximum(both[:count], both[::-1][:count]) / (2 * count)
    # What lies beyond adds up.
    return int(np.sum(np.cumsum(size[::-1]) > allowed)) + 1
