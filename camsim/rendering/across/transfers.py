"""Transfers of a lens of revolution all over the frame: along one radius, all wavelengths of a signal in one.

What differs from the perfect lens, T − Airy, is followed in all that it depends on: along the radius of the frame by
polynomials in panels, over wavelengths by one, over |f| on √(1 − ν), which takes both of its ends, round about by its
harmonics: a place turned about the axis turns them by a phase. How many nodes each takes is measured on the transfers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kept import cached_property
from camsim.optics.airy import NM_PER_UM
from camsim.products import complex_product
from camsim.rendering.across.fusing import FINEST, fused_of, fusing_of, times_of
from camsim.rendering.across.hardest import knots_within
from camsim.rendering.across.panels import Panels, panels
from camsim.rendering.across.radial_samples import TRIED, Sampler

SIX = 4.9e-3  # of a six-point look-up: times (2πδ)⁶


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

    @cached_property
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


@dataclass(frozen=True, kw_only=True, eq=False)
class TransferPlan:
    """Transfers of sets of weights within radii of the frame: how many samples they take, before most are made.

    heard : |f| in cycles/pitch → how much of an error there is
    """

    sampler: Sampler
    pitch_um: float
    heard: Callable[[F64], F64]

    @cached_property
    def _colours(self) -> tuple[F64, F64]:
        """Wavelengths that stand for all, and what each of all takes of them."""
        sampler = self.sampler
        return sampler.colours(knots_within(sampler.lens, sampler.within_um, TRIED, float(sampler.wavelength_nm[0])))

    @cached_property
    def _light(self) -> F64:
        """Of each of these, the most that a set takes."""
        light: F64 = np.abs(self.sampler.weights @ self._colours[1]).max(axis=0)
        return light

    @cached_property
    def radii(self) -> Panels:
        """Panels along the radius, µm."""
        sampler, at_nm = self.sampler, self._colours[0]
        few_nm = at_nm[np.linspace(0, at_nm.size - 1, min(TRIED, at_nm.size)).round().astype(int)]
        return panels(
            lambda um: sampler.probed(um, few_nm), *sampler.within_um, sampler.lens.height_um, sampler.allowed
        )

    @cached_property
    def _hardest(self) -> I64:
        """Numbers of the radii at which all else is measured."""
        return self.sampler.hardest(self.radii.nodes, self._colours[0])

    @cached_property
    def _ruled(self) -> list[tuple[slice, I64]]:
        """Nodes of the overlaps, by groups of wavelengths."""
        return self.sampler.ruled(self._colours[0], self._light)

    @cached_property
    def _counts(self) -> tuple[int, int]:
        """Points along √(1 − ν), and half round."""
        return self.sampler.series(self.radii.nodes[self._hardest], self._colours[0], self._light)

    def _sampled(self, radius_um: F64) -> C128:
        return self.sampler.sampled(radius_um, self._colours[0], self._ruled, *self._counts)

    @cached_property
    def _fusing(self) -> tuple[F64, float, C128]:
        """What samples weigh at the frequencies that are kept, their step in cycles/pitch, and the hardest samples."""
        sampler, (_, own), pitch_um = self.sampler, self._colours, self.pitch_um
        wavelength_nm, f_number = sampler.wavelength_nm, sampler.lens.f_number
        cut = pitch_um * NM_PER_UM / (f_number * float(wavelength_nm[0]))
        weighs = sampler.weights[:, :, None] * own
        samples = self._sampled(self.radii.nodes[self._hardest])
        finest = cut / FINEST * np.arange(FINEST + 1.0)
        fusing = fusing_of(finest / pitch_um, f_number, wavelength_nm, weighs, self._counts[0])
        times = times_of(fused_of(fusing, samples), cut, sampler.allowed, self.heard)
        return np.ascontiguousarray(fusing[:, ::times]), times * cut / FINEST, samples

    @property
    def harmonics(self) -> int:
        """How many there are."""
        return 2 * self._counts[1] - 1

    @property
    def kept_bytes(self) -> float:
        """What they take."""
        return self.most_kept_bytes * float(self._fusing[0].shape[1]) / (FINEST + 1.0)

    @property
    def most_kept_bytes(self) -> float:
        """What they would take with a step as small as there is, which is known without any samples."""
        sets, each = len(self.sampler.weights), np.dtype(complex).itemsize
        return float(each * self.radii.nodes.size * sets * (FINEST + 1) * self.harmonics)

    @property
    def seconds(self) -> float:
        """What all samples take, of one core."""
        return self.sampler.seconds(self.radii.nodes.size, self._ruled, *self._counts)

    @cached_property
    def transfers(self) -> Transfers:
        """The transfers."""
        nodes, angles, (fusing, step, known) = self.radii.nodes, self._counts[1], self._fusing
        others = np.setdiff1d(np.arange(nodes.size), self._hardest)
        samples = np.empty((nodes.size, *known.shape[1:]), complex)
        samples[self._hardest] = known
        if others.size:
            samples[others] = self._sampled(nodes[others])
        fused = fused_of(fusing, samples)
        most = angles - 1
        harmonics = np.empty((*fused.shape[:3], 2 * most + 1), complex)
        # A lens of revolution looks alike on both sides of the radius, and half a circle is the other half's conjugate.
        # One radius after the other: copies of all take several times as much.
        for out, quarter in zip(harmonics, fused, strict=True):
            half = np.concatenate([quarter, quarter[..., angles - quarter.shape[-1] : 0 : -1].conj()], axis=-1)
            spectrum = scipy.fft.fft(np.concatenate([half, half.conj()], axis=-1), axis=-1) / (2 * angles)
            out[..., :most], out[..., most:] = spectrum[..., -most:], spectrum[..., : most + 1]
        return Transfers(radii=self.radii, step=step, harmonics=harmonics)
