"""Wavelengths of the check: signals from the spectral curves, wavelength nodes, and the cutoff radius of ringing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.matrix_products import product, real_product
from camsim.numerics.quadrature import chebyshev, interpolation
from camsim.optics import OpticalSystem, RoundLens
from camsim.rendering.direct.scenery import Pieces
from camsim.rendering.direct.spread import fades, smooth_energy
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum, spectrum_at

FEWEST, MORE = 12, 4  # nodes: at least, and in addition to half a node per radian
NEAREST, FARTHEST, STEP, EACH = 4.0, 1200.0, 1.2, 8  # distances in λN of the search, their ratio, and places in each
SAME_PHASE = 2.0  # radians
AT_ONCE = 3  # distances at which coherence is summed
OF_LINE = 0.2  # ringing of a line over that of a whole circle, times the root of the distance in λN
OF_CIRCLES = 0.3  # of the allowed error for each circle: their rings meet at the centre
OF_SAMPLES = 0.4  # likewise of samples λN apart, which add up with random phases
CROWD = 4000  # largest number of edges that count; they add up with random phases
MOST_SIGNALS = 24  # spectra whose coherence is summed; others are like them


def densities(
    spectra: Sequence[Spectrum | Component], response: F64, wavelength_nm: F64, full: F64 | None = None
) -> tuple[F64, F64, F64]:
    """Return wavelengths (n,) that carry signal, signals (spectra, channels, n) at them, and full scale (channels,).

    response : (channels, m) signal of a perfect diffuser, quadrature weight included
    full     : full scale of the scene, if these spectra are only part of it
    """
    seen = (response != 0.0).any(axis=0)
    if not seen.any():
        seen = np.arange(wavelength_nm.size) == 0
    values, response = np.stack([spectrum_at(s, wavelength_nm[seen]) for s in spectra]), response[:, seen]
    if full is None:
        full = np.maximum(response.sum(axis=1), product(values, response.T).max(axis=0))
        full = np.where(full > 0.0, full, 1.0)
    return wavelength_nm[seen], values[:, None] * (response / full[:, None]), full


def condensed(wavelength_nm: F64, phase: float, allowed: float) -> tuple[F64, F64]:
    """Return Chebyshev nodes (j,) and a matrix (n, j) that moves signals to them, exact for polynomials.

    phase : change of the phase of the farthest ringing over the wavelengths;  allowed: error of a photosite
    """
    count = max(FEWEST, math.ceil(0.5 * phase + math.cbrt(phase) + MORE - 3.0 * math.log10(allowed)))
    if count >= wavelength_nm.size:
        return wavelength_nm, np.eye(wavelength_nm.size)
    low, high = float(wavelength_nm.min()), float(wavelength_nm.max())
    middle, half, nodes = 0.5 * (low + high), 0.5 * (high - low), chebyshev(count)
    return middle + half * nodes, interpolation(nodes, (wavelength_nm - middle) / half)


def counted_until(
    system: OpticalSystem,
    pitch_um: float,
    wavelength_nm: F64,
    contrast: F64,
    pieces: Pieces,
    allowed: float,
    strongest: tuple[float, float],
) -> float:
    """Return the distance, pitches, beyond which the ringing of any outline is at most ``allowed``.

    contrast  : (spectra, channels, n) signals relative to the background
    strongest : the largest step of a picture, pitches, and the brightest point, square pitches
    """
    blur = system.blurs_um(wavelength_nm) / pitch_um
    longest = float(blur.max())
    nm = float(wavelength_nm[int(blur.argmax())])
    extent = system.extent_um / pitch_um
    distance = NEAREST * np.float64(STEP) ** np.arange(math.ceil(math.log(FARTHEST / NEAREST) / math.log(STEP)))
    places = distance[:, None] + (STEP - 1.0) * distance[:, None] * np.arange(EACH) / EACH
    assert isinstance(system.lens, RoundLens)
    energy = system.lens.encircled_energy(places * longest * pitch_um, nm)
    strength = np.abs(energy - smooth_energy(system, pitch_um, nm, places * longest)).max(axis=1)
    only_fades = fades(system)  # its tail does not oscillate
    if not only_fades:
        strength *= max(system.ring_share(wavelength_nm[[0, -1]], u) for u in system.lens.pattern().breaks)
    crowd = math.sqrt(max(1.0, min(len(pieces.left), CROWD) / 4.0))
    step, point = strongest[0] / longest, strongest[1] / longest**2
    share = OF_LINE / np.sqrt(distance) * crowd + min(OF_SAMPLES * step, 1.0) + point / distance
    if only_fades:
        share = np.maximum(share, 1.0)
    elif system.chromatic and wavelength_nm.size > 1:
        # From the farthest on, up to those that count.
        counted = np.flatnonzero(strength * share > allowed)
        for end in range(len(counted), 0, -AT_ONCE):
            some = counted[max(0, end - AT_ONCE) : end]
            strength[some] *= _in_step(system.lens.pattern().breaks, blur, contrast, places[some] * longest)
            if (strength[some] * share[some] > allowed).any():
                break
    of_lines = _last(distance, strength * share, allowed)
    bent = np.flatnonzero(pieces.outlines.turn_rad != 0.0)
    radius = pieces.outlines.dx[bent] / longest
    turn = np.abs(pieces.outlines.turn_rad[bent]) / (2.0 * math.pi)
    strength_there = np.interp(radius, distance, strength) * turn > OF_CIRCLES * allowed
    of_circles = float(radius[strength_there & (radius < FARTHEST)].max(initial=0.0))
    return max(of_lines, of_circles + 2.0) * longest + extent


def _in_step(breaks: Sequence[float], blur: F64, contrast: F64, places: F64) -> F64:
    """Return the largest coherence (n,) of a spectrum's ringing over even places (n, m), pitches; 1: all in phase.

    breaks : of the transfer, in units of 1/λN;  blur: λN at all wavelengths, pitches
    """
    signals = contrast.reshape(-1, blur.size)
    signals = signals[:: max(1, len(signals) // MOST_SIGNALS)]
    per_pitch = 2.0 * math.pi / blur
    # Neighbouring wavelengths of almost the same phase are taken together.
    turns = np.floor(per_pitch * (float(places.max(initial=0.0)) / SAME_PHASE))
    first = np.flatnonzero(np.diff(turns, prepend=-1.0))
    signals, per_pitch = np.add.reduceat(signals, first, axis=1), np.add.reduceat(per_pitch, first)
    per_pitch /= np.diff(first, append=blur.size)
    most = np.zeros(places.size)
    for u in breaks:
        waves = np.empty((*per_pitch.shape, *places.shape), complex)
        waves[..., 0] = np.exp(1j * np.outer(u * per_pitch, places[:, 0]))
        waves[..., 1:] = np.exp(1j * np.outer(u * per_pitch, places[:, 1] - places[:, 0]))[..., None]
        waves = np.asarray(np.cumprod(waves, axis=-1), complex).reshape(len(waves), -1)
        most = np.maximum(most, np.abs(real_product(signals, waves)).max(axis=0, initial=0.0))
    found: F64 = np.minimum(most, 1.0).reshape(places.shape).max(axis=1, initial=0.0)
    return found


def _last(distance: np.ndarray, strength: np.ndarray, allowed: float) -> float:
    """Return the distance after the last one at which a strength exceeds ``allowed``."""
    above = np.flatnonzero(strength > allowed)
    return float(distance[min(int(above[-1]) + 1, len(distance) - 1)]) if above.size else NEAREST
