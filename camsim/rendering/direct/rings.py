"""How far the rings of a round lens are heard: so far a table of its point spread reaches."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem, RoundLens
from camsim.rendering.direct.scenery import Pieces
from camsim.rendering.direct.spread import breaks_of, fades, smooth_energy

NEAREST, FARTHEST, STEP, EACH = 4.0, 600.0, 1.2, 12  # blurs at which rings are looked at, and places in each
OF_LINE = 0.2  # a line's over a whole circle's, times the root of blurs
OF_SAMPLES = 0.4  # likewise of samples a blur apart, that add up as of random phases
CROWD = 4000  # edges, that add up as of random phases
MOST_SPECTRA = 64
DIRECTIONS = 180


def heard_until(
    system: OpticalSystem,
    pitch_um: float,
    wavelength_nm: F64,
    contrast: F64,
    pieces: Pieces,
    allowed: float,
    loudest: tuple[float, float],
) -> float:
    """Return a distance, pitches, past which rings of any outline are no louder than allowed.

    contrast : (spectra, channels, n) what each gives beside the background
    loudest  : the largest step of a picture, pitches, and the brightest point, square pitches
    """
    blur = system.blurs_um(wavelength_nm) / pitch_um
    longest = float(blur.max())
    nm = float(wavelength_nm[int(blur.argmax())])
    extent = system.extent_um / pitch_um
    distance = NEAREST * STEP ** np.arange(math.ceil(math.log(FARTHEST / NEAREST) / math.log(STEP)))
    places = distance[:, None] + (STEP - 1.0) * distance[:, None] * np.arange(EACH) / EACH
    swing = _swing(system, nm, pitch_um, places * longest).max(axis=1)
    only_fades = fades(system)  # what is left of it is no wave: it has one sign
    loud = swing if only_fades else swing * _passed(system, pitch_um, wavelength_nm)
    if system.chromatic and wavelength_nm.size > 1:
        some = contrast[:MOST_SPECTRA].reshape(-1, wavelength_nm.size)
        turns = np.exp(2j * math.pi * longest * places.ravel()[:, None] / blur)
        together = np.abs(np.einsum("sn,rn->sr", some.astype(complex), turns)).max(axis=0, initial=0.0)
        loud *= np.minimum(1.0, together.reshape(places.shape).max(axis=1))
    crowd = math.sqrt(max(1.0, min(len(pieces.left), CROWD) / 4.0))
    step, point = loudest[0] / longest, loudest[1] / longest**2
    share = OF_LINE / np.sqrt(distance) * crowd + min(OF_SAMPLES * step, 1.0) + point / distance
    of_lines = _last(distance, loud * (np.maximum(share, 1.0) if only_fades else share), allowed)
    bent = np.flatnonzero(pieces.outlines.turn_rad != 0.0)
    radius = pieces.outlines.dx[bent] / longest
    turn = np.abs(pieces.outlines.turn_rad[bent]) / (2.0 * math.pi)
    heard = np.interp(radius, distance, loud) * turn > allowed
    of_circles = float(radius[heard & (radius < FARTHEST)].max(initial=0.0))
    return max(of_lines, of_circles + 2.0) * longest + extent


def _last(distance: F64, loud: F64, allowed: float) -> float:
    """Return where something that falls is louder than allowed for the last time."""
    above = np.flatnonzero(loud > allowed)
    return float(distance[min(int(above[-1]) + 1, len(distance) - 1)]) if above.size else NEAREST


def _swing(system: OpticalSystem, nm: float, pitch_um: float, r: F64) -> F64:
    """Return how far the energy within radii r is off its smooth powers."""
    lens = system.lens
    assert isinstance(lens, RoundLens)
    swing: F64 = np.abs(lens.encircled_energy(r * pitch_um, nm) - smooth_energy(system, pitch_um, nm, r))
    return swing


def _passed(system: OpticalSystem, pitch_um: float, wavelength_nm: F64) -> float:
    """Return how much of rings OLPF and photosite pass, at the most."""
    angle = math.pi * np.arange(DIRECTIONS)[:, None] / DIRECTIONS
    f = breaks_of(system, pitch_um, wavelength_nm[[0, -1]]) / pitch_um
    return float(np.abs(system.footprint_otf(f * np.cos(angle), f * np.sin(angle))).max())
