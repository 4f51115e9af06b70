"""Transfers across lines, and what photosites see beside pieces of outlines; arrays only."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kernels import kernel
from camsim.rendering.across.kernels import AFTER, BEFORE
from camsim.rendering.angular import six_points


class Pieces(NamedTuple):
    """Pieces of runs.

    frame   : (n, 5) x and y of a piece's start, its chord's direction, and its length; pitches
    shape   : (n, DEGREE + 1) height over the chord, to its left: powers of 2·x/length − 1, the lowest first
    ends    : (n, 2, 4) x, y and direction of the lines across the run that a piece begins and ends at
    spectra : (n, 2) to the left and to the right
    """

    frame: F64
    shape: F64
    ends: F64
    spectra: I64


class Responses(NamedTuple):
    """What a photosite sees at a distance d from places along pieces, by ``step`` from −near on.

    values : (pieces, places, channels, steps);  nodes: (places,) −1 … 1 along a piece, and what tells them apart
    """

    values: F64
    nodes: F64
    weights: F64
    reach: float
    near: float
    step: float


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def look_up(table: F64, radial: F64, psi: F64, out: F64, first: int, stop: int) -> None:
    """Fill in some places (places, sets · |f|, 2)."""
    radii, count = table.shape[0], table.shape[1] - BEFORE - AFTER
    weight = np.empty(6)
    for p in range(first, stop):
        turns = psi[p] / (2.0 * math.pi)
        half = 2.0 * (turns - math.floor(turns))
        sign = 1.0 if half < 1.0 else -1.0
        at = (half - math.floor(half)) * count
        column = min(int(at), count - 1)
        six_points(at - column, weight)
        own = out[p]
        for k in range(radii):
            if radial[p, k] != 0.0:
                for a in range(6):
                    share, there = radial[p, k] * weight[a], table[k, column + a]
                    for n in range(own.shape[0]):
                        own[n, 0] += share * there[n, 0]
                        own[n, 1] += sign * share * there[n, 1]


@kernel(allocates=True, error_model="numpy", fastmath={"contract"})
def add_pieces(
    origin: tuple[float, float],
    pieces: Pieces,
    responses: Responses,
    channel: U8,
    marked: U8,
    image: F64,
    first: int,
    stop: int,
) -> None:
    """Add what pieces show to the photosites that are not marked, in rows ``first`` … ``stop``."""
    frame, shape, ends = pieces.frame, pieces.shape, pieces.ends
    values, nodes, weights, reach, step = (
        responses.values,
        responses.nodes,
        responses.weights,
        responses.reach,
        responses.step,
    )
    six, along = np.empty(6), np.empty(nodes.size)
    for e in range(len(frame)):
        x, y, tx, ty, length = frame[e, 0], frame[e, 1], frame[e, 2], frame[e, 3], frame[e, 4]
        low_x = min(x, x + length * tx) - 1.5 * reach - origin[0]
        high_x = max(x, x + length * tx) + 1.5 * reach - origin[0]
        low_y = min(y, y + length * ty) - 1.5 * reach - origin[1]
        high_y = max(y, y + length * ty) + 1.5 * reach - origin[1]
        for r in range(max(first, math.ceil(low_y)), min(stop, math.floor(high_y) + 1)):
            dy = origin[1] + r - y
            for c in range(max(0, math.ceil(low_x)), min(image.shape[1], math.floor(high_x) + 1)):
                dx = origin[0] + c - x
                over = dy * tx - dx * ty
                if marked[r, c] != 0 or abs(over) > 1.5 * reach:
                    continue
                u, v = origin[0] + c, origin[1] + r
                if (u - ends[e, 0, 0]) * ends[e, 0, 2] + (v - ends[e, 0, 1]) * ends[e, 0, 3] < 0.0:
                    continue
                if (u - ends[e, 1, 0]) * ends[e, 1, 2] + (v - ends[e, 1, 1]) * ends[e, 1, 3] >= 0.0:
                    continue
                foot = dx * tx + dy * ty
                way, height, slope, bend = foot, 0.0, 0.0, 0.0
                for _ in range(3):
                    s = 2.0 * way / length - 1.0
                    height, slope, bend = 0.0, 0.0, 0.0
                    for d in range(shape.shape[1] - 1, -1, -1):
                        bend = bend * s + 2.0 * slope
                        slope = slope * s + height
                        height = height * s + shape[e, d]
                    slope *= 2.0 / length
                    bend *= 4.0 / (length * length)
                    gap = over - height
                    way += (foot - way + gap * slope) / (1.0 + slope * slope - gap * bend)
                d = (over - height) * math.sqrt(1.0 + slope * slope)
                if abs(d) > reach:
                    continue
                s, total = 2.0 * way / length - 1.0, 0.0
                for k in range(nodes.size):
                    apart = s - nodes[k]
                    along[k] = weights[k] / (apart if abs(apart) > 1e-12 else 1e-12)
                    total += along[k]
                at = (d + responses.near) / step
                cell = int(at)
                six_points(at - cell, six)
                value = 0.0
                for k in range(nodes.size):
                    own = values[e, k, channel[r, c]]
                    seen = 0.0
                    for a in range(6):
                        seen += six[a] * own[cell - 2 + a]
                    value += along[k] * seen
                image[r, c] += value / total
