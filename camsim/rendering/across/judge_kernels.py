"""Sums over nodes of the pupil and over sides of the scene, for the check; arrays only."""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import F64, I64
from camsim.kernels import kernel
from camsim.rendering.across.turns import cos_sin, cosine
from camsim.rendering.angular import six_points

FLAT = 1e-3  # of a step: what is nearer than this to a place is there, and shows Q's slope


@kernel(error_model="numpy", fastmath={"contract"})
def add_nodes(even: F64, odd: F64, weight: F64, out: F64, first: int, stop: int) -> None:
    """Fill in some wavefronts' sums (2, wavefronts) over nodes and their mirror images, where ``even`` turns back."""
    real, imaginary = out[0, first:stop], out[1, first:stop]
    for n in range(weight.size):
        share, one, other = weight[n], even[n, first:stop], odd[n, first:stop]
        for q in range(real.size):
            c, s = cos_sin(other[q])
            both = share * cosine(one[q])
            real[q] += both * c
            imaginary[q] += both * s


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_sides(direction: F64, tables: F64, step: float, ends: F64, sides: I64, out: F64, first: int, stop: int) -> None:
    """Fill in what some directions give of every spectrum's regions: out (directions, transfers, spectra).

    direction : (directions, 2);  tables: (transfers, directions, steps) of Q, periodic
    ends      : (n, 4) x and y of where sides begin and end;  sides: (n, 2) spectra to the left and to the right
    """
    length = tables.shape[2]
    at_begin, at_end = np.empty(6), np.empty(6)
    for d in range(first, stop):
        cos, sin = direction[d]
        for e in range(len(ends)):
            x, y, u, v = ends[e]
            begin, end = (x * cos + y * sin) / step, (u * cos + v * sin) / step
            middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
            if abs(half) < FLAT:
                half = FLAT  # ends that are one place show the slope there
            begin, end = middle - half, middle + half
            turned = (cos * (v - y) - sin * (u - x)) / (2.0 * step * half)
            one, other = math.floor(begin), math.floor(end)
            six_points(begin - one, at_begin)
            six_points(end - other, at_end)
            one, other = int(one) % length, int(other) % length
            for k in range(len(tables)):
                table, value = tables[k, d], 0.0
                if 2 <= one < length - 3 and 2 <= other < length - 3:
                    for a in range(6):
                        value += at_begin[a] * table[one - 2 + a] - at_end[a] * table[other - 2 + a]
                else:
                    for a in range(6):
                        value += at_begin[a] * table[(one - 2 + a) % length]
                        value -= at_end[a] * table[(other - 2 + a) % length]
                value *= turned
                if sides[e, 0] > 0:
                    out[d, k, sides[e, 0] - 1] += value
                if sides[e, 1] > 0:
                    out[d, k, sides[e, 1] - 1] -= value
