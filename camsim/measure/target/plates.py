"""A zone plate in any picture: its centre, the growth of its ring frequency, and its contrast.

Rings of phase π·(p − p₀)ᵀK(p − p₀) + φ are a chirp: times exp(−iπk·|p|²) they are one wave, which a Fourier transform
shows as a peak. K has three numbers, for a slightly tilted plate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.picture import Plane

_SIDES = (256, 512, 1024)
"""Side of the searched area around the centre, samples: a plate of coarse rings is large."""

_STEPS = 2.0
"""Step of searched growths, fine enough that a chirp stays in phase until its rings meet the lattice."""

_FINEST = 0.04
"""Growth of frequency, cycles per sample per sample: in finer plates too few photosites cover a ghost."""

_SURE = 25.0
"""Least height of a peak relative to the root mean square of its spectrum."""

_COARSE, _INNER = 0.2, 0.4
"""Frequencies, cycles per sample, up to which rings are fitted at first, and finally."""

_LEAST_SHARE = 0.5
"""Least share of the variance within the inner rings that a plate explains."""

_ROUND = 1.5
"""Margin of a radius for elliptical rings."""

_CLIPPED, _LEAST_SAMPLES, _MOST_STEPS = 0.002, 60, 300

_ASTRAY, _SEEN = 3.0, 8.0
"""Search distance of a ghost, samples, and its least amplitude in standard errors."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rings:
    """Rings around a centre; samples and cycles per sample of one lattice.

    centre : (row, col);  growth: (2, 2) of the frequency, symmetric;  phase: of the cosine at the centre
    contrast, error : fundamental over mean at the centre, and its standard error
    """

    centre: F64
    growth: F64
    phase: float = 0.0
    contrast: float = math.nan
    error: float = math.nan

    def about(self, shape: tuple[int, ...], reach: float) -> tuple[F64, F64, F64]:
        """Return the samples where rings have a frequency below ``reach``: (row, col), offset and frequency of each."""
        across = reach / math.sqrt(abs(float(np.linalg.det(self.growth)))) * _ROUND
        ranges = [
            np.arange(max(math.floor(middle - across), 0), min(math.ceil(middle + across) + 1, size))
            for middle, size in zip(self.centre.tolist(), shape, strict=True)
        ]
        places = np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, 2)
        offset = places - self.centre
        frequency = offset @ self.growth
        near = np.hypot(frequency[:, 0], frequency[:, 1]) < reach
        return places[near], offset[near], frequency[near]

    def turn(self, offset: F64) -> F64:
        """Return the phase at offsets (n, 2) from the centre, relative to the phase of the centre."""
        turn: F64 = math.pi * np.einsum("ni,ij,nj->n", offset, self.growth, offset)
        return turn

    def shifted(self, by: F64) -> Rings:
        """Return the rings with the centre (row, col) shifted."""
        return replace(self, centre=self.centre + by)


def rings_of(planes: Sequence[Plane], name: str) -> tuple[Rings, ...]:
    """Return the rings of a picture's zone plate on each of its lattices.

    Raises UnsupportedError if none are found, or if they are clipped.
    """
    lights = [plane.samples.astype(np.float64) - plane.black for plane in planes]
    first = _found(lights[0])
    if first is None:
        message = f"channel {planes[0].name} shows no rings of a zone plate about the picture's middle"
        raise UnsupportedError(f"{message}; give a part with one in its middle", stage=name)
    found = []
    for plane, light in zip(planes, lights, strict=True):
        # The lattices are equal and interleaved.
        apart = (np.array(planes[0].first) - plane.first) / np.array(plane.step)
        rings = refined(light, first.shifted(apart), _INNER)
        if not _share_stated(light, rings) > _LEAST_SHARE:
            raise UnsupportedError(f"channel {plane.name} shows no rings where {planes[0].name} does", stage=name)
        places, _, _ = rings.about(light.shape, _INNER)
        seen = plane.samples[places[:, 0], places[:, 1]]
        if plane.white is not None and float(np.mean(seen >= plane.white)) > _CLIPPED:
            raise UnsupportedError(f"channel {plane.name} is clipped; expose less", stage=name)
        found.append(rings)
    return tuple(found)


def _found(light: F64) -> Rings | None:
    for side in _SIDES:
        rings = _searched(light, min(side, *light.shape))
        if rings is not None:
            rings = refined(light, refined(light, rings, _COARSE, growing=False), _INNER)
            if _share_stated(light, rings) > _LEAST_SHARE:
                return rings
        if side >= min(light.shape):
            break
    return None


def aligned(light: F64, rings: Rings, reach: float) -> Rings:
    """Return the rings moved to where they are strongest within a few samples, if they are significant there."""
    shifts = np.arange(-_ASTRAY, _ASTRAY + 0.25, 0.5)
    places, _, _ = rings.about(light.shape, reach)
    seen = light[places[:, 0], places[:, 1]]
    seen = seen - seen.mean()
    waves = {
        (i, j): complex(np.mean(seen * np.exp(-1j * rings.turn(places - rings.centre - (i, j)))))
        for i in shifts.tolist()
        for j in shifts.tolist()
    }
    shift, wave = max(waves.items(), key=lambda each: abs(each[1]))
    if abs(wave) < _SEEN * float(seen.std()) / math.sqrt(2.0 * len(seen)):
        return rings
    near = replace(rings.shifted(np.array(shift)), phase=float(np.angle(wave)))
    found = refined(light, near, reach, growing=False)
    return found if float(np.hypot(*(found.centre - near.centre))) < 1.0 else near


def _searched(light: F64, side: int) -> Rings | None:
    """Return the chirp with the highest peak near the centre of a picture; None if none is significant."""
    first = [(size - side) // 2 for size in light.shape]
    part = light[first[0] : first[0] + side, first[1] : first[1] + side]
    part = part - scipy.ndimage.uniform_filter(part, 31, mode="nearest")
    axis = np.arange(side) - 0.5 * (side - 1)
    square = axis**2
    scale = math.sqrt(float(np.sum(part**2)))
    if not scale > 0.0:
        return None
    best: tuple[float, float, F64] | None = None
    k = 1.0 / side
    while k < _FINEST:
        chirp = np.exp(-1j * math.pi * k * square)
        spectrum = np.abs(scipy.fft.fft2(part * chirp[:, None] * chirp[None, :]))
        peak = int(np.argmax(spectrum))
        height = float(spectrum.flat[peak]) / scale
        if best is None or height > best[0]:
            places = np.array(np.unravel_index(peak, spectrum.shape))
            best = height, k, scipy.fft.fftfreq(side)[places]
        k += k * k / _STEPS
    assert best is not None
    height, k, wave = best
    if height < _SURE:
        return None
    # Sampled rings look the same around each ghost: the true centre is where they are strongest.
    middle = np.array(first) + 0.5 * (side - 1) - wave / k
    steps = np.arange(-math.ceil(side * k), math.ceil(side * k) + 1)
    candidates = [Rings(centre=middle + np.array([i, j]) / k, growth=k * np.eye(2)) for i in steps for j in steps]
    inside = [each for each in candidates if (each.centre > 0).all() and (each.centre < light.shape).all()]
    if not inside:
        return None
    found = max(inside, key=lambda each: abs(_wave(light, each)))
    return replace(found, phase=float(np.angle(_wave(light, found))))


def _wave(light: F64, rings: Rings) -> complex:
    """Return the complex amplitude of coarse rings: half their amplitude, and their phase."""
    places, offset, _ = rings.about(light.shape, _COARSE)
    if len(places) < _LEAST_SAMPLES:
        return 0.0
    seen = light[places[:, 0], places[:, 1]]
    return complex(np.mean((seen - seen.mean()) * np.exp(-1j * rings.turn(offset))))


def _columns(rings: Rings, offset: F64) -> F64:
    """Return the design matrix of rings (n, m): shading, their decrease with frequency, third harmonics."""
    turn, frequency = rings.turn(offset) + rings.phase, offset @ rings.growth / _INNER
    wave, square = np.cos(turn), np.sum(frequency**2, axis=1)
    uneven = offset.T / np.abs(offset).max()
    hard = np.cos(3.0 * turn)
    fall = (wave, wave * square, wave * square**2, hard, hard * square)
    return np.stack([np.ones_like(turn), *uneven, *fall], axis=1)


def refined(light: F64, rings: Rings, reach: float, *, growing: bool = True) -> Rings:
    """Return the rings with centre, phase and (``growing``) growth that fit best up to a frequency, and contrast."""
    places, _, _ = rings.about(light.shape, reach)
    seen = light[places[:, 0], places[:, 1]]
    size = reach / math.sqrt(float(np.linalg.det(rings.growth)))

    def moved(by: F64) -> Rings:
        bent = np.array([[by[3], by[4]], [by[4], by[5]]]) / (math.pi * size**2) if growing else 0.0
        return replace(
            rings, centre=rings.centre + by[:2] / (math.pi * reach), growth=rings.growth + bent,
            phase=rings.phase + float(by[2]),
        )  # fmt: skip

    def left(by: F64) -> F64:
        here = moved(by)
        offset = places - here.centre
        basis = _columns(here, offset)
        rest: F64 = seen - basis @ np.linalg.solve(basis.T @ basis, basis.T @ seen)
        return rest

    found = moved(
        scipy.optimize.least_squares(left, np.zeros(6 if growing else 3), method="lm", max_nfev=_MOST_STEPS).x
    )
    offset = places - found.centre
    basis = _columns(found, offset)
    inverse = np.linalg.inv(basis.T @ basis)
    fitted = inverse @ (basis.T @ seen)
    rest = seen - basis @ fitted
    wave, mean = float(fitted[3]), float(fitted[0])
    scatter = float(rest @ rest) / max(len(seen) - basis.shape[1], 1)
    return replace(
        found,
        phase=found.phase + (math.pi if wave < 0.0 else 0.0),
        contrast=abs(wave) / mean if mean > 0.0 else math.nan,
        error=math.sqrt(scatter * float(inverse[3, 3])) / mean if mean > 0.0 else math.nan,
    )


def _share_stated(light: F64, rings: Rings) -> float:
    """Return the share of the variance in the inner area explained by the rings."""
    places, offset, _ = rings.about(light.shape, _INNER)
    seen = light[places[:, 0], places[:, 1]]
    basis = _columns(rings, offset)
    whole, rest = (seen - part @ np.linalg.solve(part.T @ part, part.T @ seen) for part in (basis[:, :3], basis))
    return 1.0 - float(rest @ rest) / max(float(whole @ whole), 1e-300)
