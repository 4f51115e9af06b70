"""Scenery that goes on for ever behind an aberrated circle: what the circle alone shows of it, and what differs.

The circle's share is two line integrals (``boundary.py``), however far outlines go. What differs falls as r⁻⁴ between
its rings: it is summed on a lattice (``waves.py``) as far as some hundred λN, where windows end it so slowly that no
ring is cut short. Of scenery that looks alike from any distance (wedges, half-planes) the light beyond goes as D⁻²,
D⁻³ … with the windows' size D: three sizes in one lattice, weighted so that the first two powers are nothing.
"""

from __future__ import annotations

import dataclasses
import math

import finufft
import numpy as np
from scipy import fft, special

from tests.truth import photosites, pupils, round_lenses, waves
from tests.truth.boundary import BoundaryTruth

SIZES = np.array([1.0, 0.8, 0.64])
POWERS = np.array([0.0, -2.0, -3.0])
TIMES = np.linalg.solve(SIZES ** POWERS[:, None], [1.0, 0.0, 0.0])
WITHIN = 0.5  # of a window's size: where it begins to fall
SPOTS = 8.0  # half widths of the spot that the wavefront makes: windows are no smaller
LARGEST = 4000  # points along a side of the lattice


class FarTruth:
    """Photosites of one picture with straight outlines.

    openings : of the wavelengths (``waves.Opening``), circles
    size     : of the largest window, in the longest wavelength's λN
    others   : as ``BoundaryTruth``
    """

    def __init__(self, pieces, openings, jumps, photosite, olpf, *, target, size):
        self.pieces, self.openings, self.photosite, self.olpf, self.size = pieces, openings, photosite, olpf, size
        self.jumps = np.asarray(jumps, float).reshape(-1, len(openings))
        self.blurs = [own.lens["blur"] * own.wavelength_nm for own in openings]
        self.moved, self.spot = _rim_and_spot(openings[0])
        hole = openings[0].lens["pupil"]["obstruction"]
        self.round = [round_lenses.Airy(blur, hole) for blur in self.blurs]
        self.whole = BoundaryTruth(pieces, self.round, self.jumps, photosite, olpf, target=target)

    def cost(self):
        """Integrands evaluated for one photosite of the circle's share, about."""
        return self.whole.cost()

    def differing(self, x, y):
        """What differs (y, x) at every x and y, and its error."""
        outer = max(self.size * max(self.blurs), SPOTS * self.spot)
        fine = self._differing(x, y, outer, 1.0)
        other = self._differing(x, y, 0.85 * outer, 1.1)
        return fine, 1.5 * float(np.abs(fine - other).max())

    def values(self, points):
        """The circle's share at points (n, 2), and the error of each."""
        return self.whole.values(np.asarray(points, float) - self.moved)

    def _differing(self, x, y, outer, spare):
        x, y = np.asarray(x, float), np.asarray(y, float)
        footprint = photosites.reach(self.photosite) + float(np.hypot(*photosites.spots(self.olpf).T).max())
        middle = 0.5 * np.array([x.min() + x.max(), y.min() + y.max()])
        half = 0.5 * max(np.ptp(x), np.ptp(y)) + footprint
        taper = (1.0 - WITHIN) * SIZES[-1] * outer
        band = spare * (1.0 / min(self.blurs) + waves.BAND / taper)
        period = 2.0 * (outer + half) * 1.01
        count = 2 * fft.next_fast_len(math.ceil(period * band))
        if count > LARGEST:
            raise pupils.TooLarge
        kx, ky = fft.fftfreq(count, 1.0 / count) / period, np.arange(count // 2 + 1) / period
        box = [self._boxed(piece, middle, 0.5 * period) for piece in self.pieces]
        rows, kind_of, times = waves.alike(self.jumps)
        total = np.zeros((ky.size, kx.size), complex)
        for row, transfer in enumerate(self._transfers(rows, outer, period, count, spare)):
            own = [(p, t) for parts, k, t in zip(box, kind_of, times, strict=True) if k == row for p in parts]
            total += waves._scene(own, kx, ky, 24) * transfer
        return waves.seen_at(x, y, total, kx, ky, self.photosite, self.olpf)

    def _transfers(self, rows, outer, period, count, spare):
        """Yield Σ over the wavelengths, (ky, kx), for every row of jumps."""
        step = period / count
        far = math.floor(outer / step)
        at = step * np.arange(-far, far + 1)
        window = sum(t * np.outer(*[_fallen(at, s * outer)] * 2) for t, s in zip(TIMES, SIZES, strict=True)) * step**2
        differ = []
        for opening, core in zip(self.openings, self.round, strict=True):
            apart = np.hypot(at - self.moved[0], (at - self.moved[1])[:, None])
            differ.append((_pattern(opening, far, step, spare) - core.pattern(apart)) * window)
        for row in rows:
            folded = np.zeros((count, count))
            place = np.arange(-far, far + 1) % count
            folded[np.ix_(place, place)] = sum(w * own for w, own in zip(row, differ, strict=True))
            yield fft.rfft2(folded.T).T

    @staticmethod
    def _boxed(piece, middle, half):
        """A piece's parts, taken along each axis to the nearest place of a box: of a closed outline what lies in it."""
        a, b = np.array(piece.start) - middle, np.array(piece.end) - middle
        with np.errstate(divide="ignore", invalid="ignore"):
            cuts = ((np.array([-half, half])[:, None] - a) / (b - a)).ravel()
        t = np.unique([0.0, *cuts[(cuts > 0.0) & (cuts < 1.0)], 1.0])[:, None]
        places = np.clip((1.0 - t) * a + t * b, -half, half) + middle
        return [
            dataclasses.replace(piece, start=tuple(p), end=tuple(q))
            for p, q in zip(places[:-1].tolist(), places[1:].tolist(), strict=True)
            if p != q
        ]


def _fallen(at, size):
    """A window: 1 as far as ``WITHIN`` of its size, then down to nothing."""
    return 0.5 * special.erfc(6.0 * (2.0 * (np.abs(at) / size - WITHIN) / (1.0 - WITHIN) - 1.0))


def _rim_and_spot(opening):
    """Where rays through the rim fall, in the mean, and how far off the axis any do, about."""
    lens, nm, step = opening.lens, opening.wavelength_nm, 1e-4
    angle, radius = np.linspace(0.0, 2.0 * np.pi, 361)[:-1], np.linspace(1.0, 0.0, 21)[:, None]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    ways = ((step, 0.0), (0.0, step))
    ahead, behind = (
        np.array([pupils.waves(lens, x + side * dx, y + side * dy, nm) for dx, dy in ways]) for side in (1.0, -1.0)
    )
    falls = lens["blur"] * nm * (ahead - behind) / step
    return falls[:, 0].mean(axis=1), float(np.hypot(*falls).max())


def _pattern(opening, far, step, spare):
    """``pupils.pattern`` on the lattice −far … far, for so many samples that the sum over its nodes is an FFT's."""
    lens, nm = opening.lens, opening.wavelength_nm
    per = 0.5 / (lens["blur"] * nm)
    nodes = math.ceil(spare * pupils.nodes_for(lens, nm, 2.0 * per * step * far))
    t, v = pupils.gauss(nodes)
    level, share, begin, end = np.array(pupils.rows_of(lens["pupil"], nodes)).T[..., None]
    x = 0.5 * (begin + end) + 0.5 * (end - begin) * t
    y = np.broadcast_to(level, x.shape)
    strength = share * 0.5 * (end - begin) * v * np.exp(2j * np.pi * pupils.waves(lens, x, y, nm))
    turn = 2.0 * np.pi * per * step
    amplitude = finufft.nufft2d1(
        turn * y.ravel(), turn * x.ravel(), strength.ravel(), (2 * far + 1, 2 * far + 1), isign=-1, eps=1e-13
    )
    return np.abs(amplitude) ** 2 * per**2 / pupils.area(lens["pupil"])
