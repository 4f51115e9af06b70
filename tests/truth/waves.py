"""All photosites behind any lens, by plain sums over the lattice of frequencies of one long period.

The point image is sampled as finely as its band asks for, out to the largest distance between a photosite and what it
sees, and from there tapered to nothing (with erfc) so that a period of that length wraps nothing round; one FFT makes
its transfer. Images that fade by themselves (Gaussians, measured ones) have their transfer in closed form. The scene's
transform is a sum over the pieces of outline, the photosite's one over its border. The error is found by computing
everything twice, with another period, taper and other nodes.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numba as nb
import numpy as np
from scipy import fft, special

from tests.truth import photosites, picture, pupils, sums
from tests.truth.beziers import Bezier
from tests.truth.pupils import TooLarge

DIGITS = 16.0
LARGEST = 2600  # points along a side of the lattice
SUM_S, PIECE_S = 1e-7, 4e-9  # a point takes, and besides for every piece of outline


class WaveTruth:
    """Photosites of one picture.

    pieces  : from ``picture.pieces``;  jumps: (pieces, n) as in ``BoundaryTruth``
    lenses  : (n,) of ``round_lenses``, or objects below
    lights  : of fields, as in ``BoundaryTruth``
    digits  : to which a taper's transform and sums of waves are followed
    """

    def __init__(self, pieces, lenses, jumps, photosite, olpf, *, lights=(), digits=DIGITS):
        self.digits = digits
        self.steep = math.sqrt(digits * math.log(10.0))  # erfc of it, and its transform as far out, have so many
        self.pieces, self.photosite, self.olpf = pieces, photosite, olpf
        self.lights = lights
        weights = np.array([one for *_, one in lights], float).reshape(-1, len(lenses))
        jumps = np.concatenate([np.reshape(jumps, (-1, len(lenses))), weights])
        self.lenses, jumps = merged(lenses, jumps)
        self.rows, self.kind_of, self.times = alike(jumps)
        self.cutoff = max(lens.cutoff for lens in self.lenses)

    def values(self, x, y):
        """Light (y, x) of the photosites at every x and y, less the background's, and the error of the worst."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        if not self.pieces and not self.lights:
            return np.zeros((y.size, x.size)), 0.0
        fine = self._values(x, y, 1.25, 1.0, 0)
        other = self._values(x, y, 1.0, 1.15, 1)
        return fine, float(np.abs(fine - other).max()) + 1e-14 * (1 + len(self.pieces))

    def plan(self, x, y, wider):
        """Centre of what is looked at, distance to keep, outer distance, period and points along a side."""
        exposed = [[*places.min(axis=0), *places.max(axis=0)] for ((places, _), *_) in self.lights]
        boxes = np.array([_box(piece) for piece in self.pieces] + exposed)
        low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
        footprint = photosites.reach(self.photosite) + float(np.hypot(*photosites.spots(self.olpf).T).max())
        first, last = np.array([x.min(), y.min()]), np.array([x.max(), y.max()])
        inner = float(np.maximum(high - first, last - low).max()) + footprint
        fading = [lens.reach for lens in self.lenses if getattr(lens, "reach", None)]
        if fading:
            # Copies a period further on must be out of reach; nothing is tapered.
            outer = max(fading) * wider
            return inner, outer, inner + outer, None, 2.0 * self.cutoff
        beyond = 1.2 * 2.0 * self.steep**2 / math.pi  # how far its transform reaches, over its width
        taper = wider * max(self.steep / self.cutoff, math.sqrt(2.0 * beyond * inner / self.cutoff))
        outer = inner + taper
        return inner, outer, inner + outer, taper, 2.0 * (self.cutoff + beyond / taper)

    def cost(self, x, y, channels=1):
        """Seconds that values of so many channels take, about; without end where the lattice is too large."""
        if not self.pieces and not self.lights:
            return 0.0
        *_, period, _, band = self.plan(np.asarray(x, float), np.asarray(y, float), 1.25)
        if period * band > LARGEST:
            return math.inf
        each_s = channels * (SUM_S + len(self.pieces) * PIECE_S) + sum(lens.sample_s for lens in self.lenses)
        return 2.0 * (period * band) ** 2 * each_s

    def _values(self, x, y, wider, spare, way):
        inner, outer, period, taper, band = self.plan(x, y, wider)
        count = fft.next_fast_len(math.ceil(period * band) | 1, real=True)
        count += count % 2
        if count > LARGEST:
            raise TooLarge
        kx, ky = fft.fftfreq(count, 1.0 / count) / period, np.arange(count // 2 + 1) / period
        transfers = self._transfers(kx, ky, period, count, inner, outer, taper, spare)
        total = np.zeros((ky.size, kx.size), complex)
        kinds, times = np.split(self.kind_of, [len(self.pieces)]), np.split(self.times, [len(self.pieces)])
        for row in range(len(self.rows)):
            one = [(p, t) for p, t, k in zip(self.pieces, times[0], kinds[0], strict=True) if k == row]
            seen = _scene(one, kx, ky, (24, 20)[way], self.digits)
            for (*ways, _), t, kind in zip(self.lights, times[1], kinds[1], strict=True):
                if kind == row:
                    places, light = ways[way]
                    seen += _points(places, t * light, kx, ky, self.digits)
            total += seen * transfers[row]
        return seen_at(x, y, total, kx, ky, self.photosite, self.olpf)

    def _transfers(self, kx, ky, period, count, inner, outer, taper, spare):
        """Σ over the wavelengths, for every row of jumps: (ky, kx)."""
        totals = [0.0] * len(self.rows)
        if taper is None:
            for j, lens in enumerate(self.lenses):
                one = lens.transfer(kx, ky)
                totals = [s + row[j] * one for s, row in zip(totals, self.rows, strict=True)]
            return totals
        step = period / count
        far = math.floor(outer / step)
        at = step * np.arange(-far, far + 1)
        window = 0.5 * special.erfc(self.steep * (2.0 * (np.abs(at) - inner) / (outer - inner) - 1.0))
        window = np.outer(window, window) * step**2
        for j, lens in enumerate(self.lenses):
            one = lens.samples(at, spare, self.digits) * window
            totals = [s + row[j] * one for s, row in zip(totals, self.rows, strict=True)]
        return [fft.rfft2(_folded(one, far, count).T).T for one in totals]


def _folded(one, far, count):
    """Samples at −far … far as those of one period: frequencies are multiples of 1/period."""
    for axis in (0, 1):
        one = np.moveaxis(one, axis, 0)
        folded = np.zeros((count, one.shape[1]))
        folded[: far + 1] = one[far:]
        folded[count - far :] += one[:far]
        one = np.moveaxis(folded, 0, axis)
    return one


def merged(lenses, jumps):
    """Lenses that are the same at several wavelengths once, with the jumps (n, wavelengths) of these added up."""
    once = list(dict.fromkeys(lenses))
    columns = [[k for k, lens in enumerate(lenses) if lens == one] for one in once]
    return once, np.stack([jumps[:, some].sum(axis=1) for some in columns], axis=1)


def alike(jumps):
    """Return rows, which row each of jumps (n, wavelengths) is a multiple of, and how many times it."""
    most = np.take_along_axis(jumps, np.argmax(np.abs(jumps), axis=1)[:, None], axis=1)
    times = np.where(most == 0.0, 1.0, most)
    rows, kind_of = np.unique(jumps / times, axis=0, return_inverse=True)
    return rows, kind_of.ravel(), times.ravel()


def seen_at(x, y, total, kx, ky, photosite, olpf):
    """Light (y, x) of photosites, from (ky, kx) the upper half of a real image's transform; ``total`` is lost."""
    total *= photosites.transfer(photosite, kx, ky) * photosites.olpf_transfer(olpf, kx, ky)
    half = kx.size // 2
    total[1:] *= 2.0
    total[half] = 0.0
    total[:, half] = 0.0
    across = np.exp(2j * np.pi * np.outer(kx, x))
    down = np.exp(2j * np.pi * np.outer(y, ky))
    return (down @ (total @ across)).real * ky[1] ** 2


class _Sampled:
    """Samples of a point image, kept: every channel asks for the same ones."""

    def __init__(self):
        self._known = {}

    def samples(self, at, spare, digits):
        key = (at.size, float(at[0]), spare)
        if key not in self._known:
            self._known[key] = self.pattern(at, spare, digits)
        return self._known[key]


class Round(_Sampled):
    """A round lens of ``round_lenses`` as samples."""

    def __init__(self, lens):
        super().__init__()
        self.lens, self.cutoff = lens, lens.cutoff
        self.sample_s = 1e-6 if hasattr(lens, "frequency") else 4e-8

    def pattern(self, at, spare, digits):
        half = at.size // 2
        r = np.hypot(at[half:], at[half:, None])
        if hasattr(self.lens, "frequency"):
            unique, back = np.unique(np.round(r, 12), return_inverse=True)
            quarter = self.lens.pattern(unique)[back].reshape(r.shape)
        else:
            quarter = self.lens.pattern(r)
        lower = np.concatenate([quarter[:, :0:-1], quarter], axis=1)
        return np.concatenate([lower[:0:-1], lower])


class Opening(_Sampled):
    """A pupil and a wavefront; ``lens['blur']``: λN in pitches per nm of wavelength."""

    sample_s = 3e-7

    def __init__(self, lens, wavelength_nm):
        super().__init__()
        self.lens, self.wavelength_nm = lens, wavelength_nm
        self.cutoff = max(pupils.extent(lens["pupil"])) / (lens["blur"] * wavelength_nm)

    def pattern(self, at, spare, digits):
        return pupils.pattern(self.lens, self.wavelength_nm, at, at, spare, digits)


class Ellipse:
    """A Gaussian with a covariance; its transfer in closed form."""

    sample_s = 4e-8

    def __init__(self, covariance):
        self.covariance = np.array(covariance, float)
        smallest, largest = np.sqrt(np.linalg.eigvalsh(self.covariance))
        self.cutoff, self.reach = 1.4 / smallest, 9.5 * largest

    def transfer(self, kx, ky):
        (xx, xy), (_, yy) = self.covariance
        ky = ky[:, None]
        return np.exp(-2.0 * np.pi**2 * (xx * kx * kx + 2.0 * xy * kx * ky + yy * ky * ky))


class Samples:
    """A measured pattern, band-limited: its samples' waves times a slope from 1 at 0.4 cycles a sample to 0 at 0.6.

    The slope is the integral of a Kaiser–Bessel window of parameter 32.
    """

    sample_s = 4e-8

    def __init__(self, irradiance, spacing):
        self.irradiance = np.array(irradiance, float)
        self.irradiance /= self.irradiance.sum()
        self.spacing = spacing
        self.cutoff = 0.6 / spacing
        rows, cols = self.irradiance.shape
        self.reach = spacing * (0.5 * math.hypot(rows, cols) + 70.0)

    def transfer(self, kx, ky):
        rows, cols = self.irradiance.shape
        at_x = (np.arange(cols) - 0.5 * (cols - 1)) * self.spacing
        at_y = (np.arange(rows) - 0.5 * (rows - 1)) * self.spacing
        across = np.exp(-2j * np.pi * np.outer(at_x, kx)) * _slope(kx * self.spacing)
        down = np.exp(-2j * np.pi * np.outer(ky, at_y)) * _slope(ky * self.spacing)[:, None]
        return down @ self.irradiance @ across


def _slope(f):
    edges = np.linspace(-1.0, 1.0, 2001)
    below = _kaiser_integral()
    t = np.clip((np.abs(f) - 0.5) / 0.1, -1.0, 1.0)
    x, w = np.polynomial.legendre.leggauss(12)
    cell = np.clip(((t + 1.0) * 1000.0).astype(int), 0, 1999)
    half = 0.5 * (t - edges[cell])
    rest = half * (_kaiser(edges[cell][..., None] + half[..., None] * (1.0 + x)) @ w)
    return 1.0 - (below[cell] + rest) / below[-1]


def _kaiser(t):
    return special.i0e(32.0 * np.sqrt(np.maximum((1.0 - t) * (1.0 + t), 0.0))) * np.exp(
        32.0 * (np.sqrt(np.maximum((1.0 - t) * (1.0 + t), 0.0)) - 1.0)
    )


@functools.cache
def _kaiser_integral():
    x, w = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(-1.0, 1.0, 2001)
    nodes = edges[:-1, None] + 0.0005 * (1.0 + x)
    return np.concatenate([[0.0], np.cumsum(0.0005 * (_kaiser(nodes) @ w))])


@dataclass(frozen=True)
class Mapped:
    """A piece of outline as it falls: ``bend`` takes places (n, 2) and steps there to where and what they become."""

    piece: picture.Piece
    bend: Callable


def _nodes(piece, highest, order):
    """Places (n, 2) along a piece, and steps there: Gauss rules of an order on panels short against a wave."""
    if isinstance(piece, Mapped):
        return piece.bend(*_nodes(piece.piece, highest, order))
    x, w = pupils.gauss(order)
    a, b = np.array(piece.start), np.array(piece.end)
    panels = max(4, math.ceil(piece.length * highest / 4.0))
    t = ((np.arange(panels)[:, None] + 0.5 * (1.0 + x)) / panels).ravel()[:, None]
    share = np.tile(0.5 / panels * w, panels)[:, None]
    if piece.straight:
        return a + t * (b - a), share * (b - a)
    if piece.points:
        curve = Bezier(piece.points)
        return curve.at(t), share * curve.slope(t)
    turn = piece.last - piece.first
    cos, sin = np.cos(piece.first + turn * t), np.sin(piece.first + turn * t)
    c, u, v = (np.array(p) for p in (piece.centre, piece.u, piece.v))
    return c + u * cos + v * sin, share * turn * (v * cos - u * sin)


def _box(piece):
    if isinstance(piece, Mapped):
        places, _ = _nodes(piece, 0.0, 24)
        return [*places.min(axis=0), *places.max(axis=0)]
    if piece.points:
        return [*np.min(piece.points, axis=0), *np.max(piece.points, axis=0)]
    if piece.centre is not None:
        c, r = np.array(piece.centre), np.hypot(piece.u, piece.v)
        return [*(c - r), *(c + r)]
    a, b = np.array(piece.start), np.array(piece.end)
    return [*np.minimum(a, b), *np.maximum(a, b)]


def _scene(one, kx, ky, order, digits):
    """∫ exp(−2πi k·y) over what lies left of the pieces, (ky, kx), each so many times: parts of closed outlines."""
    total = np.zeros((ky.size, kx.size), complex)
    straight = [(p, t) for p, t in one if not isinstance(p, Mapped) and p.straight]
    if straight:
        a, b = (np.array([getattr(p, end) for p, _ in straight]) for end in ("start", "end"))
        _straight(a, b, np.array([t for _, t in straight]), kx, ky, total)
    at_zero = sum(0.5 * t * (p.start[0] * p.end[1] - p.end[0] * p.start[1]) for p, t in straight)
    highest = math.hypot(float(np.abs(kx).max()), float(ky.max()))
    bent = [(_nodes(p, highest, order), t) for p, t in one if isinstance(p, Mapped) or not p.straight]
    if bent:
        places = np.concatenate([at for (at, _), _ in bent])
        steps = np.concatenate([t * along for (_, along), t in bent])
        # n ds is the step turned by a quarter: to its right.
        normal = np.stack([steps[:, 1], -steps[:, 0]], axis=1)
        at_zero += 0.5 * float(np.sum(places * normal))
        # ∫ exp(−2πi k·y) dA = ∮ i/(2π|k|²) (k·n) exp(−2πi k·y) ds
        total += _points(places, normal[:, 0], kx, ky, digits) * kx
        total += _points(places, normal[:, 1], kx, ky, digits) * ky[:, None]
    square = kx**2 + ky[:, None] ** 2
    square[0, 0] = 1.0
    total *= 1j / (2.0 * np.pi * square)
    total[0, 0] = at_zero
    return total


def _points(places, light, kx, ky, digits):
    """Σ light · exp(−2πi k·x), (ky, kx)."""
    return sums.over_the_plane(places, light, float(ky[1]), kx.size, digits)


@nb.njit(cache=True)
def _straight(a, b, times, kx, ky, total):
    """Add (k·n)·∫ exp(−2πi k·y) ds of straight pieces, each so many times, n to the right of their direction.

    Away from k·e = 0 that is what the waves at both ends differ by.
    """
    for p in range(len(a)):
        ex, ey = b[p, 0] - a[p, 0], b[p, 1] - a[p, 1]
        mx, my = 0.5 * (a[p, 0] + b[p, 0]), 0.5 * (a[p, 1] + b[p, 1])
        across = times[p] * np.exp(-2j * np.pi * mx * kx)
        along = np.exp(1j * np.pi * ex * kx)
        for i in range(ky.size):
            down = np.exp(-2j * np.pi * my * ky[i])
            up = np.exp(1j * np.pi * ey * ky[i])
            for j in range(kx.size):
                u = math.pi * (kx[j] * ex + ky[i] * ey)
                if abs(u) > 0.05:
                    sinc = (along[j].real * up.imag + along[j].imag * up.real) / u
                else:
                    sinc = 1.0 - u * u / 6.0 * (1.0 - u * u / 20.0 * (1.0 - u * u / 42.0 * (1.0 - u * u / 72.0)))
                total[i, j] += (kx[j] * ey - ky[i] * ex) * sinc * (down * across[j])
