"""Wavelengths of the check: signals from the spectral curves, wavelength nodes, and the cutoff radius of ringing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.core.arrays import F64
from camsim.numerics.matrix_products import product
from camsim.optics import OpticalSystem, RoundLens
from camsim.rendering.direct.scenery import Pieces
from camsim.rendering.direct.spread import breaks_of, fades, smooth_energy
from camsim.spectra.component import Component
from camsim.spectra.curve import Spectrum, spectrum_at

FEWEST, MORE = 12, 8  # nodes: at least, and in addition to half a node per radian
NEAREST, FARTHEST, STEP, EACH = 4.0, 1200.0, 1.2, 8  # distances in λN of the search, their ratio, and places in each
OF_LINE = 0.2  # ringing of a line over that of a whole circle, times the root of the distance in λN
OF_SAMPLES = 0.4  # likewise of samples λN apart, which add up with random phases
CROWD = 4000  # largest number of edges that count; they add up with random phases
MOST_SIGNALS = 24  # spectra whose coherence is summed; others are like them
DIRECTIONS = 180  # over half a turn, a degree apart


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
    density = np.stack([spectrum_at(s, wavelength_nm[seen]) for s in spectra])[:, None] * response[None, :, seen]
    if full is None:
        full = np.maximum(response.sum(axis=1), density.sum(axis=2).max(axis=0))
        full = np.where(full > 0.0, full, 1.0)
    return wavelength_nm[seen], density / full[:, None], full


def count_of(count: int, phase: float, allowed: float) -> int:
    """Return the number of nodes for ``count`` wavelengths; see ``condensed``."""
    return min(count, max(FEWEST, math.ceil(0.5 * phase + math.cbrt(phase) + MORE - 3.0 * math.log10(allowed))))


def condensed(wavelength_nm: F64, count: int) -> tuple[F64, F64]:
    """Return Chebyshev nodes (count,) and a matrix (n, count) that moves signals to them, exact for polynomials."""
    if wavelength_nm.size == count:
        return wavelength_nm, np.eye(count)
    low, high = float(wavelength_nm.min()), float(wavelength_nm.max())
    angle = math.pi * (np.arange(count) + 0.5) / count
    nodes = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(angle)
    # ℓ_j(x) = (2/n) Σ' T_k(x_j)·T_k(x): sums of cosines avoid cancellation between neighbours.
    place = np.arccos(np.clip((low + high - 2.0 * wavelength_nm) / (high - low), -1.0, 1.0))
    degree = np.arange(count)
    at_nodes, at_places = np.cos(np.outer(degree, angle)), np.cos(np.outer(degree, place))
    at_places[0] *= 0.5
    return nodes, (2.0 / count) * product(np.ascontiguousarray(at_places.T), at_nodes)


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
    amplitude = _ringing_amplitude(system, nm, pitch_um, places * longest).max(axis=1)
    only_fades = fades(system)  # its tail does not oscillate
    strength = amplitude if only_fades else amplitude * _passed(system, pitch_um, wavelength_nm)
    crowd = math.sqrt(max(1.0, min(len(pieces.left), CROWD) / 4.0))
    step, point = strongest[0] / longest, strongest[1] / longest**2
    share = OF_LINE / np.sqrt(distance) * crowd + min(OF_SAMPLES * step, 1.0) + point / distance
    if only_fades:
        share = np.maximum(share, 1.0)
    elif system.chromatic and wavelength_nm.size > 1:
        counted = np.flatnonzero(strength * share > allowed)
        strength[counted] *= _in_step(system, pitch_um, wavelength_nm, contrast, places[counted] * longest)
    of_lines = _last(distance, strength * share, allowed)
    bent = np.flatnonzero(pieces.outlines.turn_rad != 0.0)
    radius = pieces.outlines.dx[bent] / longest
    turn = np.abs(pieces.outlines.turn_rad[bent]) / (2.0 * math.pi)
    strength_there = np.interp(radius, distance, strength) * turn > allowed
    of_circles = float(radius[strength_there & (radius < FARTHEST)].max(initial=0.0))
    return max(of_lines, of_circles + 2.0) * longest + extent


def _in_step(system: OpticalSystem, pitch_um: float, wavelength_nm: F64, contrast: F64, places: F64) -> F64:
    """Return the largest coherence (n,) of a spectrum's ringing over places (n, m), pitches: 1 if all is in phase."""
    signals = contrast.reshape(-1, wavelength_nm.size)
    signals = signals[:: max(1, len(signals) // MOST_SIGNALS)].astype(complex)
    assert isinstance(system.lens, RoundLens)
    most = np.zeros(places.size)
    for u in system.lens.pattern().breaks:
        turns = np.exp((2j * math.pi * u) * places.ravel()[:, None] / (system.blurs_um(wavelength_nm) / pitch_um))
        most = np.maximum(most, np.abs(np.einsum("sn,rn->sr", signals, turns)).max(axis=0, initial=0.0))
    found: F64 = np.minimum(most, 1.0).reshape(places.shape).max(axis=1, initial=0.0)
    return found


def _last(distance: np.ndarray, strength: np.ndarray, allowed: float) -> float:
    """Return the distance after the last one at which a strength exceeds ``allowed``."""
    above = np.flatnonzero(strength > allowed)
    return float(distance[min(int(above[-1]) + 1, len(distance) - 1)]) if above.size else NEAREST


def _ringing_amplitude(system: OpticalSystem, nm: float, pitch_um: float, r: F64) -> F64:
    """Return the oscillatory part of the encircled energy within radii r, pitches, as an absolute value."""
    lens = system.lens
    assert isinstance(lens, RoundLens)
    amplitude: F64 = np.abs(lens.encircled_energy(r * pitch_um, nm) - smooth_energy(system, pitch_um, nm, r))
    return amplitude


def _passed(system: OpticalSystem, pitch_um: float, wavelength_nm: F64) -> float:
    """Return the largest transfer of OLPF and photosite at the frequencies of the ringing."""
    angle = math.pi * np.arange(DIRECTIONS)[:, None] / DIRECTIONS
    f = breaks_of(system, pitch_um, wavelength_nm[[0, -1]]) / pitch_um
    return float(np.abs(system.footprint_otf(f * np.cos(angle), f * np.sin(angle))).max())
