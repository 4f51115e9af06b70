"""What photosites see of the slivers between bent edges and their chords; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

from camsim.arrays import F64, I64, U8
from camsim.kernels import kernel

BLOCK = 8  # nodes that are one, seen from afar


class Slivers(NamedTuple):
    """Chords, and nodes along them.

    frame  : (n, 6) x and y of a chord's start, its direction, its length, and how far off it matters; pitches
    first  : (n + 1,) where each one's nodes begin;  alike: (n,) the table that each is looked up in
    nodes  : (3, m) x and y half way to the bent edge, and what lies between as light of 1 a square pitch
    blocks : (3, m') the same of ``BLOCK`` nodes together, of each chord from ``first_block`` on
    """

    frame: F64
    first: I64
    alike: I64
    nodes: F64
    first_block: I64
    blocks: F64


class Pattern(NamedTuple):
    """What a photosite sees of a point, (tables, channels, x, y), ``per_pitch`` steps a pitch, itself in the middle.

    tail : (tables, channels) of 1/r³, farther away than ``near``
    """

    values: F64
    per_pitch: float
    near: float
    tail: F64


@kernel(forceinline=True)
def _four(t: float) -> tuple[float, float, float, float]:
    """What values at −1 … 2 weigh at t, 0 … 1."""
    a, b, c = t + 1.0, t - 1.0, t - 2.0
    return -t * b * c / 6.0, 0.5 * a * b * c, -0.5 * a * t * c, a * t * b / 6.0


@kernel(error_model="numpy", fastmath={"contract"})
def add_slivers(
    origin: tuple[float, float],
    slivers: Slivers,
    pattern: Pattern,
    channel: U8,
    image: F64,
    first: int,
    stop: int,
) -> None:
    """Add what the photosites of some rows see."""
    per, middle = pattern.per_pitch, pattern.values.shape[2] // 2
    for k in range(len(slivers.frame)):
        x, y, tx, ty, length, reach = slivers.frame[k]
        begin, end, which = slivers.first_block[k], slivers.first_block[k + 1], slivers.alike[k]
        low_x, high_x = min(x, x + length * tx) - reach - origin[0], max(x, x + length * tx) + reach - origin[0]
        low_y, high_y = min(y, y + length * ty) - reach - origin[1], max(y, y + length * ty) + reach - origin[1]
        for r in range(max(first, math.ceil(low_y)), min(stop, math.floor(high_y) + 1)):
            v = origin[1] + r
            for c in range(max(0, math.ceil(low_x)), min(image.shape[1], math.floor(high_x) + 1)):
                u = origin[0] + c
                along = (u - x) * tx + (v - y) * ty
                if abs((v - y) * tx - (u - x) * ty) > reach or along < -reach or along > length + reach:
                    continue
                values, tail, seen = pattern.values[which, channel[r, c]], pattern.tail[which, channel[r, c]], 0.0
                for block in range(begin, end):
                    dx, dy = u - slivers.blocks[0, block], v - slivers.blocks[1, block]
                    square = dx * dx + dy * dy
                    if square > pattern.near * pattern.near:
                        seen += slivers.blocks[2, block] * tail / (square * math.sqrt(square))
                        continue
                    node = slivers.first[k] + BLOCK * (block - begin)
                    for n in range(node, min(node + BLOCK, slivers.first[k + 1])):
                        at_x, at_y = (u - slivers.nodes[0, n]) * per + middle, (v - slivers.nodes[1, n]) * per + middle
                        i, j = int(at_x), int(at_y)
                        w0, w1, w2, w3 = _four(at_y - j)
                        a0, a1, a2, a3 = _four(at_x - i)
                        one, two, three, four = values[i - 1], values[i], values[i + 1], values[i + 2]
                        value = a0 * (w0 * one[j - 1] + w1 * one[j] + w2 * one[j + 1] + w3 * one[j + 2])
                        value += a1 * (w0 * two[j - 1] + w1 * two[j] + w2 * two[j + 1] + w3 * two[j + 2])
                        value += a2 * (w0 * three[j - 1] + w1 * three[j] + w2 * three[j + 1] + w3 * three[j + 2])
                        value += a3 * (w0 * four[j - 1] + w1 * four[j] + w2 * four[j + 1] + w3 * four[j + 2])
                        seen += slivers.nodes[2, n] * value
                image[r, c] += seen
