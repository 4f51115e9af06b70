"""Transfers of round pupils with many wavefronts at once: overlaps of two shifted copies, summed by one rule for all.

T(ν, θ) = (1/π)·∫ exp(2πi·[W(p − d) − W(p + d)]) dp over the lens that two circles of radius 1 share, ν in units of the
cut-off, d = ν·(cos θ, sin θ). W is linear in its coefficients: a node's polynomials serve all of them. At −p what even
polynomials give changes its sign, what odd ones give does not: half of the lens serves for the whole, with 2·cos(2πe)·
exp(2πi·o). Across, where the lens is pointed at its ends, it takes more nodes than along the shift.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import C128, F64, I64
from camsim.kernels import kernel, shared
from camsim.optics.zernike import orders, radial_powers
from camsim.quadrature import even_rule
from camsim.rendering.across.turns import cos_sin, cosine

AT_ONCE = 128  # wavefronts whose phases stay in the nearest cache


class Terms(NamedTuple):
    """Zernike polynomials as the kernel takes them: polynomials in r², highest power first, times r^m·cos or sin mθ."""

    powers: F64  # (k, p)
    order: I64  # (k,) m
    sine: I64  # (k,) 1: sin

    @classmethod
    def of(cls, zernike: tuple[int, ...]) -> Terms:
        """Return those of OSA indices."""
        each = [radial_powers(index) for index in zernike]
        powers = np.zeros((len(each), max((p.size for p in each), default=1)))
        for own, p in zip(powers, each, strict=True):
            own[powers.shape[1] - p.size :] = p
        m = np.array([orders(index)[1] for index in zernike], np.int64)
        return cls(powers, np.abs(m), (m < 0).astype(np.int64))


def overlaps(terms: Terms, waves: F64, shift: F64, angle_rad: F64, nodes: tuple[int, int]) -> C128:
    """Return transfers (wavefronts, shifts, angles).

    waves : (k, wavefronts) coefficients;  shift: ν, 0 … 1;  nodes: of the rule, an even number across, and along
    """
    across, along = (even_rule(count) for count in nodes)
    out = np.empty((shift.size, angle_rad.size, 2, waves.shape[1]))
    whole = np.ascontiguousarray(waves)
    shared(
        shift.size * angle_rad.size, functools.partial(_overlaps, terms, whole, shift, angle_rad, across, along, out)
    )
    found: C128 = np.moveaxis(out[:, :, 0] + 1j * out[:, :, 1], 2, 0)
    return found


@kernel(error_model="numpy", fastmath={"contract"})
def _overlaps(
    terms: Terms,
    waves: F64,
    shift: F64,
    angle_rad: F64,
    rule: tuple[F64, F64],
    rule_along: tuple[F64, F64],
    out: F64,
    first: int,
    stop: int,
) -> None:
    """Fill in some of (shifts · angles)."""
    count, many = waves.shape
    (t, v), (s, w) = rule, rule_along
    nodes = t.size // 2 * s.size
    steps = np.empty((nodes, count))
    share = np.empty(nodes)
    even, odd, real, imaginary = np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE), np.empty(AT_ONCE)
    for place in range(first, stop):
        nu, angle = shift[place // angle_rad.size], angle_rad[place % angle_rad.size]
        cos, sin = math.cos(angle), math.sin(angle)
        widest = math.sqrt(max(1.0 - nu * nu, 0.0))
        for a in range(t.size // 2):
            # Spaced as a cosine across: what is left of a line's length at either end are square roots.
            turn = 0.5 * math.pi * (1.0 + t[a])
            across, slope = -widest * math.cos(turn), 0.5 * math.pi * widest * math.sin(turn) * v[a]
            half = max(math.sqrt(max(1.0 - across * across, 0.0)) - nu, 0.0)
            for b in range(s.size):
                along, n = half * s[b], a * s.size + b
                share[n] = 2.0 * slope * half * w[b] / math.pi
                for z in range(count):
                    steps[n, z] = 0.0
                for side in range(2):
                    u = along - nu if side == 0 else along + nu
                    x, y = u * cos - across * sin, u * sin + across * cos
                    square = x * x + y * y
                    for z in range(count):
                        value = terms.powers[z, 0]
                        for p in range(1, terms.powers.shape[1]):
                            value = value * square + terms.powers[z, p]
                        part, other = 1.0, 0.0
                        for _ in range(terms.order[z]):
                            part, other = part * x - other * y, part * y + other * x
                        value *= other if terms.sine[z] else part
                        steps[n, z] += value if side == 0 else -value
        for low in range(0, many, AT_ONCE):
            width = min(AT_ONCE, many - low)
            real[:], imaginary[:] = 0.0, 0.0
            for n in range(nodes):
                even[:], odd[:] = 0.0, 0.0
                for z in range(count):
                    step, own = steps[n, z], waves[z, low : low + width]
                    phase = odd if terms.order[z] % 2 else even
                    for q in range(width):
                        phase[q] += step * own[q]
                weight = share[n]
                for q in range(width):
                    c, d = cos_sin(odd[q])
                    both = weight * cosine(even[q])
                    real[q] += both * c
                    imaginary[q] += both * d
            for q in range(width):
                out[place // angle_rad.size, place % angle_rad.size, 0, low + q] = real[q]
                out[place // angle_rad.size, place % angle_rad.size, 1, low + q] = imaginary[q]
