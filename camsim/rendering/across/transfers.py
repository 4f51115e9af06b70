"""Transfers of a lens of revolution all over the frame: along one radius, all wavelengths of a signal in one.

What differs from the perfect lens, T − Airy, is followed in all that it depends on: along the radius of the frame by
polynomials in panels, over wavelengths by one, over |f| on √(1 − ν), which takes both of its ends, round about by its
harmonics: a place turned about the axis turns them by a phase. How many nodes each takes is measured on the transfers.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.errors import UnsupportedError
from camsim.optics.airy import NM_PER_UM
from camsim.optics.placed import Revolves
from camsim.products import complex_product
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.across.fusing import FINEST, fused_of, fusing_of, times_of
from camsim.rendering.across.hardest import hardest, heights_within, knots_within, waves_at
from camsim.rendering.across.overlap import Terms, overlaps
from camsim.rendering.across.panels import Panels, panels

RULES = (8, 12, 16, 20, 24, 28, 32, 40, 48, 64, 96, 128, 160, 208, 256, 320, 400, 512)  # of the overlap, either way
SERIES = (32, 64, 128, 256, 512)  # points on which a series' end is looked for
SHIFTS = np.array([0.03, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95])  # where nodes are counted
ANGLES = 0.5 * math.pi * np.linspace(0.0, 1.0, 13)  # a term cos mθ is steepest in m directions: of all small m
FEW = ANGLES[::3]  # of what is compared at many places
TRIED, FOLLOWED = 5, 2  # places, and wavelengths, at which the others' nodes are counted; and how far series go
MARGIN = 2  # harmonics more
TURNS = 8  # times m of terms cos mθ: so many harmonics are looked at, as of a single one each 2m-th is something
GROUPS = 8  # of wavelengths, that have a rule in common
SIX = 4.9e-3  # of a six-point look-up: times (2πδ)⁶
COLOURS = (12, 16, 20, 24, 28, 32, 36, 40, 44, 48, 56, 64, 80, 96, 128, 192, 256)  # nodes of a spectrum


@dataclass(frozen=True, kw_only=True, eq=False)
class Transfers:
    """What a lens adds to the perfect one's transfer.

    radii       : panels along the radius, µm
    step        : of |f|, cycles/pitch
    harmonics   : (radii, sets, |f|, 2·most + 1) of exp(imθ), m = −most … most; the place lies at +x
    """

    radii: Panels
    step: float
    harmonics: C128

    @property
    def most(self) -> int:
        """The highest harmonic."""
        return int(self.harmonics.shape[-1]) // 2

    @functools.cached_property
    def _by_harmonic(self) -> C128:
        """The same as (harmonics, radii, sets, |f|)."""
        return np.ascontiguousarray(np.moveaxis(self.harmonics, 3, 0))

    def made(self, made_of: C128, stop: int) -> C128:
        """Return what is made (harmonics, sets, terms, |f|), up to a frequency; made_of: (terms, radii, harmonics)."""
        used = np.flatnonzero(np.abs(made_of).max(axis=(0, 2)) > 0.0)
        some = slice(int(used[0]), int(used[-1]) + 1)
        own = self._by_harmonic[:, some, :, :stop]
        harmonics, radii, sets, _ = own.shape
        made = np.empty((harmonics, len(made_of), sets * stop), complex)
        for out, weights, values in zip(made, np.moveaxis(made_of[:, some], 2, 0), own, strict=True):
            out[:] = complex_product(weights, values.reshape(radii, -1))
        return np.swapaxes(made.reshape(harmonics, len(made_of), sets, stop), 1, 2)

    def turns(self, angle_rad: F64) -> C128:
        """Return what harmonics weigh (places, harmonics) where a place is turned about the axis."""
        m = np.arange(-self.most, self.most + 1)
        turns: C128 = np.exp(-1j * np.multiply.outer(angle_rad, m))
        return turns


def fused_transfers(
    lens: Revolves,
    wavelength_nm: F64,
    weights: F64,
    *,
    pitch_um: float,
    radii_um: tuple[float, float],
    allowed: float,
    heard: Callable[[F64], F64],
) -> Transfers:
    """Return the transfers of sets of weights (sets, wavelengths) within radii of the frame.

    allowed : of a transfer where it is heard;  heard: |f| in cycles/pitch → how much of an error there is
    """
    work = _Sampler(lens, wavelength_nm, weights, radii_um, allowed)
    at_nm, own = work.colours(knots_within(lens, radii_um, TRIED, float(wavelength_nm[0])))
    few_nm = at_nm[np.linspace(0, at_nm.size - 1, min(TRIED, at_nm.size)).round().astype(int)]
    radii = panels(lambda um: work.probed(um, few_nm), *radii_um, lens.height_um, allowed)
    light = np.abs(weights @ own).max(axis=0)
    some = work.hardest(radii.nodes, at_nm)
    shifts, angles = np.max([work.series(float(um), at_nm, light) for um in radii.nodes[some]], axis=0).tolist()
    samples = work.sampled(radii.nodes, at_nm, light, shifts, angles)

    cut = pitch_um * NM_PER_UM / (lens.f_number * float(wavelength_nm[0]))
    finest = cut / FINEST * np.arange(FINEST + 1.0)
    fusing = fusing_of(finest / pitch_um, lens.f_number, wavelength_nm, weights[:, :, None] * own, shifts)
    times = times_of(fused_of(fusing, samples[some]), cut, allowed, heard)
    step = times * cut / FINEST
    fused = fused_of(np.ascontiguousarray(fusing[:, ::times]), samples)
    most = angles - 1
    harmonics = np.empty((*fused.shape[:3], 2 * most + 1), complex)
    # A lens of revolution looks alike on both sides of the radius, and half a circle is the other half's conjugate.
    for out, quarter in zip(harmonics, fused, strict=True):  # one after the other: copies take several times as much
        half = np.concatenate([quarter, quarter[..., angles - quarter.shape[-1] : 0 : -1].conj()], axis=-1)
        spectrum = scipy.fft.fft(np.concatenate([half, half.conj()], axis=-1), axis=-1) / (2 * angles)
        out[..., :most], out[..., most:] = spectrum[..., -most:], spectrum[..., : most + 1]
    return Transfers(radii=radii, step=step, harmonics=harmonics)


class _Sampler:
    """What samples monochromatic transfers along the radius, less the perfect one's."""

    def __init__(
        self, lens: Revolves, wavelength_nm: F64, weights: F64, radii_um: tuple[float, float], allowed: float
    ) -> None:
        self.lens, self.wavelength_nm, self.weights, self.allowed = lens, wavelength_nm, weights, allowed
        self.zernike = lens.at(lens.height_um[-1], 0.0).zernike
        self.terms = Terms.of(self.zernike)
        self.order = int(self.terms.order.max(initial=0))
        self.radii_um = np.array([*radii_um, *heights_within(lens, radii_um)])
        self.rules = self._rules(wavelength_nm, allowed)

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
                raise _unfollowed(f"{RULES[-1]} × {RULES[-1]} nodes of their overlaps")
            for rules[1, k] in RULES:
                found = overlaps(self.terms, waves, own, ANGLES, (int(rules[0, k]), int(rules[1, k])))
                if float(np.abs(found - right).max()) <= 2.0 * allowed:
                    break
        return rules

    def _overlaps(self, waves: F64, shift: F64, angle_rad: F64, rules: I64) -> C128:
        """Return transfers (wavefronts, shifts, angles), each by as many nodes as its shift takes."""
        out = np.empty((waves.shape[1], shift.size, angle_rad.size), complex)
        after = np.clip(np.searchsorted(SHIFTS, shift), 0, SHIFTS.size - 1)
        nodes = np.maximum(rules[:, after], rules[:, np.maximum(after - 1, 0)])
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

    def series(self, radius_um: float, wavelength_nm: F64, light: F64) -> tuple[int, int]:
        """Return how many points along √(1 − ν), and half round, follow the transfers at a radius.

        light : of each wavelength, the most that a set takes
        """
        waves = waves_at(self.lens, np.array([radius_um]), wavelength_nm)
        ends = []
        for along in (True, False):
            for count in SERIES if along else [own for own in SERIES if own >= TURNS * self.order]:
                shift = 1.0 - (0.5 * (1.0 + chebyshev(count))) ** 2 if along else SHIFTS
                angle = FEW if along else math.pi * np.arange(count) / count
                found = self._overlaps(waves, shift, angle, self.rules)
                if along:
                    each = np.abs(scipy.fft.dct(found.real, axis=1)) + np.abs(scipy.fft.dct(found.imag, axis=1))
                    size = np.einsum("k,knd->nd", light, each).max(axis=1) / count
                else:
                    each = np.abs(scipy.fft.fft(np.concatenate([found, found.conj()], axis=2), axis=2))
                    both = np.einsum("k,kdn->dn", light, each).max(axis=0)
                    size = np.maximum(both[:count], both[::-1][:count]) / (2 * count)
                # What lies beyond adds up.
                end = int(np.sum(np.cumsum(size[::-1]) > self.allowed)) + 1
                if end <= 0.75 * count:
                    break
            else:
                raise _unfollowed(f"series of {SERIES[-1]} terms")
            ends.append(end + MARGIN)
        return ends[0], ends[1]

    def sampled(self, radius_um: F64, wavelength_nm: F64, light: F64, shifts: int, angles: int) -> C128:
        """Return (radii, wavelengths · shifts, angles) of T − Airy, a quarter of a circle of angles.

        Wavelengths of little light, of which wavefronts may be steepest, take few nodes.
        """
        shift = 1.0 - (0.5 * (1.0 + chebyshev(shifts))) ** 2
        angle = math.pi * np.arange(angles // 2 + 1) / angles
        out = np.empty((radius_um.size, wavelength_nm.size, shifts, angle.size), complex)
        for part in np.array_split(np.arange(wavelength_nm.size), min(GROUPS, wavelength_nm.size)):
            own_nm = wavelength_nm[part]
            rules = self._rules(own_nm, self.allowed / max(GROUPS * float(light[part].sum()), 1e-300))
            waves = waves_at(self.lens, radius_um, own_nm)
            # Less the perfect one's by the same nodes: what they lose of the pupil, both do.
            found = self._overlaps(np.append(waves, np.zeros((len(waves), 1)), axis=1), shift, angle, rules)
            out[:, part] = (found[:-1] - found[-1]).reshape(radius_um.size, part.size, shifts, angle.size)
        return out.reshape(radius_um.size, -1, angle.size)


def _unfollowed(what: str) -> UnsupportedError:
    return UnsupportedError(
        f"its wavefronts turn too often for {what}: weaker aberrations, or method: fourier", key="lens"
    )
