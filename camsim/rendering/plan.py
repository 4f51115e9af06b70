"""The boundary engine's settings, chosen from the tolerance by an error model before anything is computed.

Sources of error, each given a share of the tolerance (amplitudes are for a contrast of 1):

* The far form leaves out what oscillates with cos(2πr/λN). Per end at distance R it is at most
  (λN/R)^{5/2}·D/(4π⁴), D the footprint's transfer at 1/λN; a whole line twice that. Over a spectrum the
  wavelengths are added as the phasors that they are, sign of D included.
* The footprint's moments end at the fourth: next come |M8|/(16π R⁸) and about 3·c1·M6/(2π R⁷).
* The 8-point look-up in the field: 1.1e-3·(2πδ/λN)⁸ of the field's highest frequencies; the panels' Gauss rule.
* Chebyshev interpolation over a tile: ρ⁻ⁿ with ρ = κ + √(1 + κ²), a source κ half-widths away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.rendering.footprint import Footprint

COARSEST, FINEST = 1e-2, 1e-9
FEWEST_LAMBDA_N = 5.0  # no far form is used closer than this
DULL = 3.0  # what many wavelengths leave is not the leading term alone: measured up to twice it at 6 λN


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Settings of one boundary rendering; lengths in pitches."""

    tolerance: float
    near: float
    reach: float
    field_step: float
    response_step: float
    panel: float
    panel_nodes: int
    tile_nodes: int
    separation: float = 2.0
    root: int = 64
    leaf: int = 16


def check_tolerance(tolerance: float) -> None:
    """Refuse what the engine cannot promise."""
    if not FINEST <= tolerance <= COARSEST:
        raise InvalidValueError(f"tolerance: {tolerance:g} is outside {FINEST:g} … {COARSEST:g} (boundary engine)")


def plan_boundary(lambda_n: F64, shares: F64, footprint: Footprint, tolerance: float) -> Settings:
    """Choose the settings.

    lambda_n : (j,) λN in pitches
    shares   : (k, j) weights of every weight set, relative to that channel's full scale
    """
    check_tolerance(tolerance)
    shortest, longest = float(lambda_n.min()), float(lambda_n.max())
    near = max(
        FEWEST_LAMBDA_N * longest,
        quiet_distance(lambda_n, shares, footprint, 0.25 * tolerance, end=True),
        _moment_distance(longest, footprint, 0.125 * tolerance),
    )
    reach = max(near, quiet_distance(lambda_n, shares, footprint, tolerance / 6.0, end=False))
    field_step = shortest * min(0.2, (tolerance / 20.0 / 2e-5) ** (1.0 / 8.0) / (2.0 * math.pi))
    response_step = shortest * min(0.1, (tolerance / 20.0 / 1e-4) ** (1.0 / 6.0) / (2.0 * math.pi))
    digits = -math.log10(tolerance)
    return Settings(
        tolerance=tolerance,
        near=near,
        reach=reach,
        field_step=field_step,
        response_step=response_step,
        panel=shortest * 1.6,
        panel_nodes=math.ceil(4 + 0.5 * digits),
        tile_nodes=max(4, math.ceil((digits + 0.5) / math.log10(2.0 + math.sqrt(5.0)))),
    )


def quiet_distance(lambda_n: F64, shares: F64, footprint: Footprint, allowed: float, *, end: bool) -> float:
    """Distance beyond which what oscillates at an edge's end (else: across a whole line) stays below ``allowed``."""
    amplitude = 1.0 / ((4.0 if end else 2.0) * math.pi**4)
    shortest, longest = float(lambda_n.min()), float(lambda_n.max())
    phasor = shares[None] * (lambda_n**2.5 * footprint.transfer(1.0 / lambda_n))[:, None]
    phasor = phasor.reshape(-1, lambda_n.size)
    farthest: float = float(np.abs(phasor).sum(axis=1).max() * amplitude / allowed) ** 0.4
    if shortest == longest or farthest <= FEWEST_LAMBDA_N * longest:
        return farthest
    distance = np.arange(FEWEST_LAMBDA_N * longest, farthest + longest, 0.25 * longest)
    wave = np.exp(2j * np.pi * distance[:, None] / lambda_n)
    loudest = DULL * np.abs(wave @ phasor.T).max(axis=1) * amplitude * distance**-2.5
    loud = np.flatnonzero(loudest > allowed)
    return float(distance[min(loud[-1] + 1, distance.size - 1)]) if loud.size else float(distance[0])


def _moment_distance(longest: float, footprint: Footprint, allowed: float) -> float:
    """Distance beyond which the footprint's moments past the fourth stay below ``allowed``."""
    eighth: float = (footprint.m8 / (16.0 * math.pi * allowed)) ** (1.0 / 8.0)
    c1 = 2.0 * longest / math.pi**2
    sixth: float = (3.0 * c1 * footprint.m6 / (2.0 * math.pi * allowed)) ** (1.0 / 7.0)
    return max(eighth, sixth)
