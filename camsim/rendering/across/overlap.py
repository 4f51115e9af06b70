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
from camsim.optics.zernike import norm, orders, radial_steps
from camsim.quadrature import even_rule
from camsim.rendering.across.turns import cos_sin, cosine

NODES = 512  # whose phases stay in the nearest cache


class Terms(NamedTuple):
    """Zernike polynomials as the kernel takes them: norm·P_p(r²) times r^m·cos or sin mθ."""

    steps: F64  # (k, most p + 1, 3) see ``radial_steps``
    degree: I64  # (k,) p
    norm: F64  # (k,)
    order: I64  # (k,) m
    sine: I64  # (k,) 1: sin

    @classmethod
    def of(cls, zernike: tuple[int, ...]) -> Terms:
        """Return those of OSA indices."""
        n, m = np.array([orders(index) for index in zernike], np.int64).reshape(-1, 2).T
        order = np.abs(m)
        degree = (n - order) // 2
        most = int(degree.max(initial=0)) + 1
        steps = np.array([radial_steps(own, most) for own in order.tolist()]).reshape(-1, most, 3)
        return cls(steps, degree, np.array([norm(index) for index in zernike]), order, (m < 0).astype(np.int64))


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


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
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
    nodes = rule[0].size // 2 * rule_along[0].size
    steps, turned, share = np.empty((count, 2, nodes)), np.empty((count, NODES)), np.empty(nodes)
    even, odd, real, imaginary = np.empty(NODES), np.empty(NODES), np.empty(NODES), np.empty(NODES)
    ready = -1
    for place in range(first, stop):
        row, col = place // angle_rad.size, place % angle_rad.size
        if row != ready:
            ready = row
            _steps(terms, shift[row], rule, rule_along, steps, share)
        out[row, col] = 0.0
        for low in range(0, nodes, NODES):
            width = min(NODES, nodes - low)
            for z in range(count):
                # r^m·exp(imφ) turned by the angle: its real part for a cosine, its imaginary one for a sine.
                cos, sin = math.cos(terms.order[z] * angle_rad[col]), math.sin(terms.order[z] * angle_rad[col])
                if terms.sine[z]:
                    cos, sin = sin, -cos
                for n in range(width):
                    turned[z, n] = cos * steps[z, 0, low + n] - sin * steps[z, 1, low + n]
            for q in range(many):
                for n in range(width):
                    even[n], odd[n] = 0.0, 0.0
                for z in range(count):
                    phase, own = odd if terms.order[z] % 2 else even, waves[z, q]
                    for n in range(width):
                        phase[n] += own * turned[z, n]
                for n in range(width):
                    c, d = cos_sin(odd[n])
                    both = share[low + n] * cosine(even[n])
                    real[n] = both * c
                    imaginary[n] = both * d
                out[row, col, 0, q] += _total(real, width)
                out[row, col, 1, q] += _total(imaginary, width)


@kernel(fastmath={"reassoc"})
def _total(values: F64, width: int) -> float:
    total = 0.0
    for n in range(width):
        total += values[n]
    return total


@kernel(error_model="numpy", fastmath={"contract"})
def _steps(terms: Terms, nu: float, rule: tuple[F64, F64], rule_along: tuple[F64, F64], steps: F64, share: F64) -> None:
    """Fill in what polynomials differ by at nodes, a shift along x (k, 2, n): R·r^m·exp(imφ); and shares (n,)."""
    count = steps.shape[0]
    (t, v), (s, w) = rule, rule_along
    widest = math.sqrt(max(1.0 - nu * nu, 0.0))
    for a in range(t.size // 2):
        # Spaced as a cosine across: what is left of a line's length at either end are square roots.
        turn = 0.5 * math.pi * (1.0 + t[a])
        across, slope = -widest * math.cos(turn), 0.5 * math.pi * widest * math.sin(turn) * v[a]
        half = max(math.sqrt(max(1.0 - across * across, 0.0)) - nu, 0.0)
        for b in range(s.size):
            along, n = half * s[b], a * s.size + b
            share[n] = 2.0 * slope * half * w[b] / math.pi
            steps[:, :, n] = 0.0
            for side in range(2):
                x, sign = (along - nu, 1.0) if side == 0 else (along + nu, -1.0)
                square = x * x + across * across
                for z in range(count):
                    value, before = 1.0, 0.0
                    for p in range(1, terms.degree[z] + 1):
                        rise, rest, less = terms.steps[z, p]
                        value, before = (rise * square + rest) * value - less * before, value
                    part, other = sign * terms.norm[z] * value, 0.0
                    for _ in range(terms.order[z]):
                        part, other = part * x - other * across, part * across + other * x
                    steps[z, 0, n] += part
                    steps[z, 1, n] += other
