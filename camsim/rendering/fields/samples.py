"""A layer ready to be transformed: a lattice of splines, and points of light that correct them at its outline.

Splines of visible samples are used uncut. Where the outline cuts the field, or a spline extends beyond it, the
difference between the visible field and these splines is integrated patch by patch with Gauss nodes: a patch is a
square between neighbouring knots, on which the field is a polynomial. The nodes become points of light.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.core.arrays import F64, I64, distinct
from camsim.numerics.quadrature import gauss_legendre, gauss_pieces
from camsim.rendering.fields.cover import Cover, cover_of
from camsim.rendering.fields.layer import Layer, basis, refined

LONGEST_PATCH = 9.0  # radians: phase of half a patch at the highest frequency up to which samples are not refined
LONGEST_SQUARE = 8.0  # pitches: larger squares would extend too far beyond a window's support
THREE = 3  # samples that replace one in a refinement
LEAST_NODES, MOST_NODES = 3, 64
CLIPPED = 8  # samples retained beside the part of a picture that is needed


class Splines(NamedTuple):
    """A layer as splines on a lattice, and points of light that correct their errors; pitches.

    first  : (2,) position of the first sample;  ways: (2, 2) steps along rows and down columns
    light  : (kinds, rows, cols)
    points : (m, 2);  corrections: (kinds, m)
    step, degree : spacing of the samples, and degree of the splines
    """

    first: F64
    ways: F64
    light: F64
    points: F64
    corrections: F64
    step: float
    degree: int

    @property
    def places(self) -> F64:
        """Positions of the samples (rows, cols, 2)."""
        rows, cols = (np.arange(count) for count in self.light.shape[1:])
        places: F64 = self.first + cols[None, :, None] * self.ways[0] + rows[:, None, None] * self.ways[1]
        return places

    def passes(self, frequency: F64) -> F64:
        """Return the transform of one sample along an axis."""
        passes: F64 = np.sinc(self.step * frequency) ** (self.degree + 1)
        return passes


class Support(NamedTuple):
    """A box (low, high), pitches, outside of which only frequencies up to ``cut`` cycles/pitch are needed; 0: none."""

    low: F64
    high: F64
    cut: float


def splines_of(
    layer: Layer, *, cut: float, allowed: float, support: Support | None = None, longest: float = math.inf
) -> Splines:
    """Return a layer as splines and corrections.

    cut : highest frequency needed, cycles/pitch;  allowed: relative error of the quadrature
    longest : largest spacing of samples, pitches
    """
    times, parts = 1, max(parts_of(layer, cut), math.ceil(layer.step / longest - 1e-9))
    around = 0 if layer.degree == 0 else layer.degree + 2
    rows, cols = (range(-around, count + around) for count in layer.shape)
    if support is not None and not support.cut:
        cols, rows = (_clipped(one, *ends) for one, ends in zip((cols, rows), layer.within(*support[:2]), strict=True))
    fine = layer.coefficients(rows, cols)
    while times < parts:
        fine, times = refined(fine, layer.degree, THREE), THREE * times
        trimmed = [
            range(max(3 * r.start, -around), min(3 * r.stop, n * times + around))
            for r, n in zip((rows, cols), layer.shape, strict=True)
        ]
        fine = fine[:, _within(trimmed[0], rows), _within(trimmed[1], cols)]
        rows, cols = trimmed
    step = layer.step / times
    first = layer.places(np.array([[cols.start + 0.5, rows.start + 0.5]]) / times)[0]
    splines = Splines(
        first, step * layer.axes, step**2 * fine, np.empty((0, 2)), np.empty((len(fine), 0)), step, layer.degree
    )
    if layer.degree == 0 and layer.outline is None:
        return splines
    cover, knot = _cover(layer, times, (rows.start, cols.start), fine.shape[1:])
    # A spline is used uncut if a patch that it covers is entirely visible: patches a − n … a + n − 1 for sample a.
    n = (layer.degree + 1) // 2
    keep = _any(cover.whole, range(-n, n)) if n else cover.whole
    patches = np.argwhere((_any(keep, range(1 - n, n + 1)) if n else keep) & ~cover.whole)
    lattice = np.where(keep, fine, 0.0)
    both = patches, cover.cut
    near, found = [np.ones(len(one), bool) for one in both], []
    if support is not None:
        middles = [layer.places((knot + one[:, ::-1] + 0.5) / times) for one in both]
        near = [np.all((one >= support.low) & (one <= support.high), axis=1) for one in middles]
        if support.cut:
            far = [~one for one in near]
            found.append(_corrections(layer, fine, lattice, cover, patches, far, math.pi * support.cut * step, allowed))
    found.append(_corrections(layer, fine, lattice, cover, patches, near, math.pi * cut * step, allowed))
    points = layer.places((knot + np.concatenate([one for one, _ in found])) / times)
    corrections = step**2 * np.concatenate([one for _, one in found], axis=1)
    return splines._replace(light=step**2 * lattice, points=points, corrections=corrections)


def parts_of(layer: Layer, cut: float) -> int:
    """Return the refinement of samples, a power of three, that makes patches small enough to be integrated."""
    whole = layer.degree == 0 and layer.outline is None
    longest = max(LONGEST_SQUARE, 0.5 / cut) if whole else LONGEST_PATCH / (math.pi * cut)
    return int(THREE ** max(0, math.ceil(math.log(layer.step / longest, THREE) - 1e-9)))


def _clipped(whole: range, low: float, high: float) -> range:
    """Return the samples of a range within a part of the picture, with a margin for splines and their refinement."""
    first = min(max(whole.start, math.floor(low) - CLIPPED), whole.stop - 1)
    return range(first, max(min(whole.stop, math.ceil(high) + CLIPPED), first + 1))


def _within(part: range, whole: range) -> slice:
    """Return the slice of the samples ``part`` within the refinement of all samples ``whole``."""
    first = part.start - THREE * whole.start
    return slice(first, first + len(part))


def _cover(layer: Layer, times: int, first: tuple[int, int], shape: tuple[int, ...]) -> tuple[Cover, F64]:
    """Return the visibility of each patch, and the position (u, v) of the first knot, in fine samples.

    Patch p lies between the knots p and p + 1: the sides of squares for degree 0, else the samples p and p + 1.
    """
    half = 0.0 if layer.degree == 0 else 0.5
    knot = np.array([first[1], first[0]], float) + half
    rows, cols = layer.shape
    if layer.outline is None:
        corners = np.array([[0.0, 0.0], [cols, 0.0], [cols, rows], [0.0, rows]])
        outline = corners, np.roll(corners, -1, axis=0)
    else:
        outline = layer.outline
    start, end = (times * part - knot for part in outline)
    return cover_of((start, end), (shape[0], shape[1])), knot


def _any(mask: np.ndarray, shifts: range) -> np.ndarray:
    """Return a mask (rows, cols): whether any place at these shifts, along both axes, is in the mask."""
    middle = shifts.start + len(shifts) // 2
    for axis in (0, 1):
        mask = scipy.ndimage.maximum_filter1d(mask, len(shifts), axis=axis, mode="constant", origin=-middle)
    return mask


def _corrections(
    layer: Layer,
    fine: F64,
    lattice: F64,
    cover: Cover,
    patches: I64,
    among: list[np.ndarray],
    phase: float,
    allowed: float,
) -> tuple[F64, F64]:
    """Return nodes (m, 2) and light (planes, m): the visible field on patches minus that of the uncut splines.

    patches : (n, 2) row and column of patches, not entirely visible, that uncut splines cover
    among   : which of these, and which of those of ``cover.cut``, to consider
    phase   : radians over half a patch at the highest frequency
    """
    pieces, orders = gauss_pieces(np.array([phase]), allowed, MOST_NODES)
    x, w = _composite(int(pieces[0]), max(int(orders[0]) + 1, LEAST_NODES))

    # Subtract the uncut splines over the whole patch.
    patch = patches[among[0]]
    t = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    taken = _on_grids(lattice, layer.degree, patch, x) * -np.outer(w, w).ravel()
    nodes, light = [(patch[:, None, ::-1] + t).reshape(-1, 2)], [taken.reshape(len(fine), -1)]

    # Add the visible part: signed triangles from one of its corners to every edge, by Duffy's transformation; those
    # that begin or end there have no area. The coordinate along the edge needs fewer nodes for short edges.
    corner = cover.start[np.searchsorted(cover.owner, cover.owner)]
    start, end, length = cover.start - corner, cover.end - corner, np.hypot(*(cover.end - cover.start).T)
    mine = among[1][cover.owner] if len(cover.owner) else np.empty(0, bool)
    mine = mine & (start != 0.0).any(axis=1) & (end != 0.0).any(axis=1)
    needed = np.minimum(x.size, np.ceil(x.size * length).astype(np.int64) + 3)
    for order in distinct(needed[mine]).tolist():
        these = mine & (needed == order)
        a, b, of = start[these], end[these], cover.cut[cover.owner[these]]
        first = 0.5 + corner[these][:, None]
        s, ws = _composite(1, order) if order < x.size else (x, w)
        along, across = (part.ravel() for part in np.meshgrid(x, s))
        inside = along[None, :, None] * (a[:, None] + across[None, :, None] * (b - a)[:, None])
        twice = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        seen = _values(fine, layer.degree, of, first + inside)
        seen *= twice[:, None] * (np.outer(ws, w).ravel() * along)
        nodes.append((of[:, None, ::-1] + first + inside).reshape(-1, 2))
        light.append(seen.reshape(len(fine), -1))
    return np.concatenate(nodes), np.concatenate(light, axis=1)


def _composite(pieces: int, order: int) -> tuple[F64, F64]:
    """Return a composite Gauss rule on 0 … 1."""
    x, w = gauss_legendre(order)
    nodes = (np.arange(pieces)[:, None] + 0.5 * (1.0 + x)) / pieces
    return nodes.ravel(), np.tile(0.5 * w / pieces, pieces)


def _on_grids(coefficients: F64, degree: int, patch: I64, x: F64) -> F64:
    """Return the field (planes, patches, n²) on the grid of places x (n,), 0 … 1, in each patch."""
    weights = basis(degree, x).T
    part = np.stack([_window(coefficients, degree, patch, i, j) for i in range(degree + 1) for j in range(degree + 1)])
    part = part.reshape(degree + 1, degree + 1, len(coefficients), len(patch))
    rows = np.einsum("xj,ijpm->pmix", weights, part)
    values: F64 = np.einsum("yi,pmix->pmyx", weights, rows).reshape(len(coefficients), len(patch), x.size**2)
    return values


def _window(coefficients: F64, degree: int, patch: I64, i: int, j: int) -> F64:
    """Return the coefficient (planes, patches) of the spline in row i and column j of those that cover a patch."""
    n, (rows, cols) = max((degree + 1) // 2 - 1, 0), coefficients.shape[1:]
    window: F64 = coefficients[:, np.clip(patch[:, 0] + i - n, 0, rows - 1), np.clip(patch[:, 1] + j - n, 0, cols - 1)]
    return window


def _values(coefficients: F64, degree: int, patch: I64, t: F64) -> F64:
    """Return the field (planes, patches, nodes) at places t (patches, nodes, 2), 0 … 1 along and down each patch."""
    across, down = basis(degree, t[..., 0]), basis(degree, t[..., 1])
    out = np.zeros((len(coefficients), *t.shape[:2]))
    for i in range(degree + 1):
        for j in range(degree + 1):
            out += _window(coefficients, degree, patch, i, j)[:, :, None] * (down[i] * across[j])
    return out
