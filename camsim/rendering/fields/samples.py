"""A layer near a window, ready to be transformed: a lattice of splines, and points that stand for what they get wrong.

Splines whose samples can be seen are kept whole. Where the outline cuts the field, or a spline reaches beyond it, the
difference between what is to be seen and what the kept splines give is integrated patch by patch with Gauss nodes: a
patch is a square between neighbouring knots, and the field on it a polynomial. The nodes are points of light.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import F64, I64
from camsim.quadrature import gauss_legendre, gauss_pieces
from camsim.rendering.fields.cover import Cover, cover_of
from camsim.rendering.fields.layer import Layer, basis, reach_of, refined
from camsim.rendering.fields.light import Lattice, Samples
from camsim.rendering.fields.points import PointLayer

LONGEST_PATCH = 9.0  # radians of half a patch's phase at the highest frequency, before its samples are refined
LONGEST_SQUARE = 8.0  # pitches: larger squares would bring in light from beyond what a window takes
THREE = 3  # samples in place of one
MOST_NODES = 64


class Splines(NamedTuple):
    """A layer as splines on a lattice, and points of light that say what they get wrong; pitches.

    places : (rows, cols, 2) of samples;  light: (kinds, rows, cols)
    points : (m, 2);  corrections: (kinds, m)
    step, degree : of the splines;  gathered: spreads that samples were gathered by, (width, β, step) each
    """

    places: F64
    light: F64
    points: F64
    corrections: F64
    step: float
    spline_step: float
    degree: int
    gathered: tuple[tuple[int, float, float], ...] = ()

    def passes(self, frequency: F64) -> F64:
        """Return the transform of one sample along an axis."""
        passes = np.sinc(self.spline_step * frequency) ** (self.degree + 1)
        for width, beta, step in self.gathered:
            passes = passes / _window_transform(frequency * step, width, beta)
        return passes

    def halved(self, precision: float) -> Splines:
        """Return half as many samples along either axis, of the same transform at low frequencies."""
        width = 2 * math.ceil((math.log(1.0 / precision) / 2.2 + 1.0) / 2.0) + 2
        beta = 0.74 * math.pi * width
        rows, cols = self.light.shape[1:]
        axes = (
            self.places[0, 1] - self.places[0, 0] if cols > 1 else np.zeros(2),
            (self.places[1, 0] - self.places[0, 0] if rows > 1 else np.zeros(2)),
        )
        light = self.light
        for axis in (1, 2):
            matrix = _gathering(light.shape[axis], width, beta)
            moved = np.moveaxis(light, axis, 0)
            light = np.moveaxis((matrix @ moved.reshape(len(moved), -1)).reshape(-1, *moved.shape[1:]), 0, axis)
        more = width // 2
        row, col = (2.0 * (np.arange(n) - more) for n in light.shape[1:])
        places = self.places[0, 0] + col[None, :, None] * axes[0] + row[:, None, None] * axes[1]
        return self._replace(
            places=places, light=light, step=2.0 * self.step, gathered=(*self.gathered, (width, beta, 2.0 * self.step))
        )


def _gathering(count: int, width: int, beta: float) -> scipy.sparse.csr_array:
    """Return the matrix that spreads samples on every second one, from width // 2 of these before the first on."""
    more = width // 2
    place = 0.5 * np.arange(count)[:, None]
    first = np.floor(place) - more + 1
    coarse = first + np.arange(width)
    t = 2.0 * (place - coarse) / width
    weight = np.i0(beta * np.sqrt(np.maximum(1.0 - t * t, 0.0))) / np.i0(beta)
    rows, cols = (coarse + more).astype(int).ravel(), np.repeat(np.arange(count), width)
    total = int(rows.max()) + 1
    return scipy.sparse.csr_array((weight.ravel(), (rows, cols)), shape=(total, count))


def _window_transform(frequency: F64, width: int, beta: float) -> F64:
    """Return the transform of the spreading window, frequencies in cycles a coarse sample."""
    root = np.sqrt(np.maximum(beta * beta - (np.pi * width * frequency) ** 2, 1e-12))
    values: F64 = width * np.sinh(root) / root / np.i0(beta)
    return values


def splines_of(layer: Layer, *, cut: float, allowed: float, longest: float = math.inf) -> Splines:
    """Return all of a layer.

    cut : highest frequency that is asked, cycles/pitch;  allowed: error of the nodes, relative
    longest : distance of samples, pitches
    """
    times, parts = 1, max(parts_of(layer, cut), math.ceil(layer.step / longest - 1e-9))
    around = 0 if layer.degree == 0 else layer.degree + 2
    rows, cols = (range(-around, count + around) for count in layer.shape)
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
    corner = layer.places(np.array([[cols.start + 0.5, rows.start + 0.5]]) / times)[0]
    across, down = step * np.arange(fine.shape[2]), step * np.arange(fine.shape[1])
    places = corner + across[None, :, None] * layer.axes[0] + down[:, None, None] * layer.axes[1]
    if layer.degree == 0 and layer.outline is None:
        return Splines(places, step**2 * fine, np.empty((0, 2)), np.empty((len(fine), 0)), step, step, 0)
    cover, knot = _cover(layer, times, (rows.start, cols.start), fine.shape[1:])
    keep = _kept(cover.whole, layer.degree)
    lattice = np.where(keep, fine, 0.0)
    everywhere = np.full(2, -1e300), np.full(2, 1e300)
    points, corrections = _corrections(
        layer, times, fine, lattice, cover, knot, everywhere, np.zeros(2), cut=cut, allowed=allowed
    )
    return Splines(places, step**2 * lattice, points, corrections, step, step, layer.degree)


def samples_of(
    layer: Layer | PointLayer,
    low: F64,
    high: F64,
    *,
    cut: float,
    allowed: float,
    origin: tuple[float, float],
    aligned: bool = False,
) -> Samples | None:
    """Return what of a layer lies in a box, exactly, and perhaps a little more beyond it; None where nothing does.

    low, high : (2,) of the box, pitches from ``origin``;  cut: highest frequency, cycles/pitch
    allowed   : error of the nodes, relative;  aligned: whether splines along the photosites' rows come as a lattice
    """
    if isinstance(layer, PointLayer):
        return layer.within(low, high, origin)
    at = np.array(origin)
    box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]) + at
    u, v = layer.samples_at(box).T
    times = 1
    rows, cols = _window(layer, v, 1, layer.shape[0]), _window(layer, u, 1, layer.shape[1])
    if not len(rows) or not len(cols):
        return None
    fine = layer.coefficients(rows, cols)
    while times < parts_of(layer, cut):
        fine, times = refined(fine, layer.degree, THREE), THREE * times
        below, beside = _window(layer, v, times, layer.shape[0]), _window(layer, u, times, layer.shape[1])
        fine = fine[:, _within(below, rows), _within(beside, cols)]
        rows, cols = below, beside
    step = layer.step / times
    margin = reach_of(layer.degree, step)
    # Sample (row, col) of the fine lattice lies at u = (col + 1/2)/times.
    first = layer.places(np.array([[cols.start + 0.5, rows.start + 0.5]]) / times)[0] - at
    beyond = low - 2.0 * margin, high + 2.0 * margin
    if layer.degree == 0 and layer.outline is None:
        keep = np.ones(fine.shape[1:], bool)
        points, corrections = np.empty((0, 2)), np.empty((len(fine), 0))
    else:
        cover, knot = _cover(layer, times, (rows.start, cols.start), fine.shape[1:])
        keep = _kept(cover.whole, layer.degree) & _in_box(layer, first, step, fine.shape[1:], beyond)
        near = low - margin, high + margin
        lattice = np.where(keep, fine, 0.0)
        points, corrections = _corrections(layer, times, fine, lattice, cover, knot, near, at, cut=cut, allowed=allowed)
    if aligned:
        return Samples(
            lattice=_upright(layer, step**2 * (fine if keep.all() else np.where(keep, fine, 0.0)), first, step, beyond),
            places=np.empty((0, 2)),
            strengths=np.empty((len(fine), 0)),
            points=points,
            corrections=corrections,
            step=step,
            degree=layer.degree,
            axes=layer.axes,
        )
    keep &= _in_box(layer, first, step, fine.shape[1:], beyond)
    row, col = np.nonzero(keep)
    return Samples(
        lattice=None,
        places=first + step * np.einsum("na,ax->nx", np.stack([col, row], axis=1), layer.axes),
        strengths=step**2 * fine[:, row, col],
        points=points,
        corrections=corrections,
        step=step,
        degree=layer.degree,
        axes=layer.axes,
    )


def _in_box(layer: Layer, first: F64, step: float, shape: tuple[int, ...], box: tuple[F64, F64]) -> np.ndarray:
    """Return (rows, cols): which samples lie in a box; ``first``: where the first one is."""
    down, across = (step * np.arange(count) for count in shape)
    inside = np.ones(shape, bool)
    for axis in (0, 1):
        place = first[axis] + across * layer.axes[0, axis] + (down * layer.axes[1, axis])[:, None]
        inside &= (place >= box[0][axis]) & (place <= box[1][axis])
    return inside


def _upright(layer: Layer, light: F64, first: F64, step: float, box: tuple[F64, F64]) -> Lattice:
    """Return samples (planes, rows, cols) of a layer that lies along the photosites' rows, those in a box."""
    if layer.axes[0, 0] == 0.0:
        light = light.transpose(0, 2, 1)
    signs = layer.axes.sum(axis=0)  # of the steps along x and y
    corner = []
    for axis, sign in enumerate(signs.tolist()):
        place = first[axis] + sign * step * np.arange(light.shape[2 - axis])
        inside = np.flatnonzero((place >= box[0][axis]) & (place <= box[1][axis]))
        inside = inside[:: int(sign)]
        if not inside.size:
            return Lattice(np.zeros((len(light), 1, 1)), (float(first[0]), float(first[1])), step, layer.degree)
        corner.append(float(place[inside[0]]))
        part = slice(int(inside.min()), int(inside.max()) + 1)
        light = light[:, :, part][:, :, :: int(sign)] if axis == 0 else light[:, part][:, :: int(sign)]
    return Lattice(light, (corner[0], corner[1]), step, layer.degree)


def parts_of(layer: Layer | PointLayer, cut: float) -> int:
    """Return into how many parts, a power of three, samples are refined: where patches are cut they are to be small."""
    whole = layer.degree == 0 and layer.outline is None
    longest = max(LONGEST_SQUARE, 0.5 / cut) if whole else LONGEST_PATCH / (math.pi * cut)
    return int(THREE ** max(0, math.ceil(math.log(layer.step / longest, THREE) - 1e-9)))


def _window(layer: Layer, places: F64, times: int, count: int) -> range:
    """Return the samples of a box, refined: those of the picture, and around as many as splines there reach.

    Mirrored samples beyond the picture's rim carry the splines on; and refining spoils the outermost ones.
    """
    around = 0 if layer.degree == 0 else layer.degree + 2
    beyond = 2.0 * reach_of(layer.degree, 1.0) + 2.0 + around
    first = max(-around, math.floor(float(places.min()) * times - beyond))
    stop = min(count * times + around, math.ceil(float(places.max()) * times + beyond))
    return range(first, max(first, stop))


def _within(part: range, whole: range) -> slice:
    """Return where refined samples lie among all that were made of ``whole``."""
    first = part.start - THREE * whole.start
    return slice(first, first + len(part))


def _cover(layer: Layer, times: int, first: tuple[int, int], shape: tuple[int, ...]) -> tuple[Cover, F64]:
    """Return what of each patch is seen, and where (u, v) the first one's first knot lies, in fine samples.

    Patch p lies between the knots p and p + 1: sides of squares, or else the samples p and p + 1.
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


def _kept(whole: np.ndarray, degree: int) -> np.ndarray:
    """Return which samples are kept: those of which some patch is wholly seen."""
    if degree == 0:
        return whole.copy()
    # Sample a is felt on the patches a − n … a + n − 1.
    n = (degree + 1) // 2
    keep = whole
    for axis in (0, 1):
        total = np.zeros_like(keep)
        for shift in range(-n, n):
            total |= _shifted(keep, shift, axis)
        keep = total
    return keep


def _corrections(
    layer: Layer,
    times: int,
    fine: F64,
    lattice: F64,
    cover: Cover,
    knot: F64,
    box: tuple[F64, F64],
    at: F64,
    *,
    cut: float,
    allowed: float,
) -> tuple[F64, F64]:
    """Return nodes (m, 2) and light (planes, m): what is seen of patches less what the kept splines give there."""
    step = layer.step / times
    given = _patches(np.abs(lattice).sum(axis=0)[None], layer.degree)[0] > 0.0
    wrong = given & ~cover.whole
    here = np.zeros_like(wrong)
    here[tuple(cover.cut.T)] = True
    rows, cols = np.nonzero(wrong | here)
    middle = layer.places((knot + np.stack([cols, rows], axis=1) + 0.5) / times) - at
    near = ((middle >= box[0]) & (middle <= box[1])).all(axis=1)
    wanted = np.zeros_like(wrong)
    wanted[rows[near], cols[near]] = True
    phase = np.array([math.pi * cut * step])
    pieces, orders = gauss_pieces(phase, allowed, MOST_NODES)
    x, w = _composite(int(pieces[0]), int(orders[0]) + 2)

    # The kept splines, over all of a patch.
    patch = np.argwhere(wrong & wanted)
    t = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    whole_at = patch[:, None, ::-1] + t
    taken = _values(lattice, layer.degree, patch, np.broadcast_to(t, (len(patch), *t.shape))) * -np.outer(w, w).ravel()

    nodes, light = [whole_at.reshape(-1, 2)], [taken.reshape(len(fine), -1)]

    # What is seen of it: triangles from its middle to every edge, of either sign, as Duffy's squares: out from the
    # middle, and along the edge, where short ones need fewer nodes.
    mine = np.flatnonzero(wanted[tuple(cover.cut.T)][cover.owner]) if len(cover.owner) else np.empty(0, np.int64)
    length = np.hypot(*(cover.end - cover.start)[mine].T)
    needed = np.minimum(x.size, np.ceil(x.size * length).astype(np.int64) + 3)
    for order in np.unique(needed).tolist():
        these = mine[needed == order]
        a, b, of = cover.start[these], cover.end[these], cover.cut[cover.owner[these]]
        s, ws = _composite(1, order) if order < x.size else (x, w)
        along, across = (part.ravel() for part in np.meshgrid(x, s))
        inside = along[None, :, None] * (a[:, None] + across[None, :, None] * (b - a)[:, None])
        twice = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        seen = _values(fine, layer.degree, of, 0.5 + inside)
        seen *= twice[:, None] * (np.outer(ws, w).ravel() * along)
        nodes.append((of[:, None, ::-1] + 0.5 + inside).reshape(-1, 2))
        light.append(seen.reshape(len(fine), -1))
    places = layer.places((knot + np.concatenate(nodes)) / times) - at
    return places, step**2 * np.concatenate(light, axis=1)


def _patches(values: F64, degree: int) -> F64:
    """Return the sums over the samples that are felt on each patch."""
    if degree == 0:
        return values
    n = (degree + 1) // 2
    for axis in (1, 2):
        values = sum(_shifted(values, shift, axis) for shift in range(1 - n, n + 1))  # type: ignore[assignment]
    return values


def _shifted(values: np.ndarray, shift: int, axis: int) -> np.ndarray:
    """Return what lies ``shift`` places further along an axis; nothing lies beyond its ends."""
    moved = np.roll(values, -shift, axis=axis)
    ends = slice(-shift, None) if shift > 0 else slice(0, -shift)
    moved[(slice(None),) * axis + (ends,)] = 0
    return moved


def _composite(pieces: int, order: int) -> tuple[F64, F64]:
    """Return a Gauss rule on 0 … 1 in pieces."""
    x, w = gauss_legendre(order)
    nodes = (np.arange(pieces)[:, None] + 0.5 * (1.0 + x)) / pieces
    return nodes.ravel(), np.tile(0.5 * w / pieces, pieces)


def _values(coefficients: F64, degree: int, patch: I64, t: F64) -> F64:
    """Return (planes, patches, nodes): the field at places t (patches, nodes, 2), 0 … 1 along and down each patch."""
    if not len(patch):
        return np.zeros((len(coefficients), 0, t.shape[1]))
    n = max((degree + 1) // 2 - 1, 0)
    across = basis(degree, t[..., 0].ravel()).reshape(*t.shape[:2], -1)
    down = basis(degree, t[..., 1].ravel()).reshape(*t.shape[:2], -1)
    out = np.zeros((len(coefficients), *t.shape[:2]))
    rows, cols = coefficients.shape[1:]
    for i in range(degree + 1):
        for j in range(degree + 1):
            own = coefficients[:, np.clip(patch[:, 0] + i - n, 0, rows - 1), np.clip(patch[:, 1] + j - n, 0, cols - 1)]
            out += own[:, :, None] * (down[..., i] * across[..., j])
    return out
