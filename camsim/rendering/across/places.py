"""Few transfers that stand for all places of a box: images with them are added up with weights of every photosite.

Chebyshev places along x and y, as many as their transfers ask for; of these, one after the other, the one that those
before it follow worst, until what is left of all is nothing that a line could show.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.products import product
from camsim.rendering.across.kernels import add_weighed
from camsim.rendering.across.lattice import cardinal, nodes
from camsim.rendering.across.transfers import Transfers
from camsim.rendering.fast_length import fast_length
from camsim.rendering.grid import Grid

COARSE = 40  # frequencies at which places are compared
ALONG, LEFT, CUT = 0.25, 0.3, 0.2  # of what places may leave: along x and y each, all but some terms, their ends
WEIGHED = 50_000  # products that are worth a thread's while
WIDER = 0.08  # of the highest frequency: more that waves have which are multiplied by weights
MOST_PLACES = 14  # along a side of a box
LOUDEST = 12  # directions, of all sets, that are looked at between places


class Box(NamedTuple):
    """Photosites row … row + rows, col … col + cols, of a window whose first one is at ``first_um``."""

    row: int
    col: int
    rows: int
    cols: int
    first_um: tuple[float, float]
    pitch_um: float

    @classmethod
    def window(cls, grid: Grid) -> Box:
        """Return all photosites of a window."""
        x0, y0 = grid.first_centre
        return cls(0, 0, grid.rows, grid.cols, (x0 * grid.pitch_um, y0 * grid.pitch_um), grid.pitch_um)

    def places_um(self, x: F64, y: F64) -> F64:
        """Return places (n, 2) from their coordinates in the box, −1 … 1 along either side."""
        first = self.first_um[0] + self.col * self.pitch_um, self.first_um[1] + self.row * self.pitch_um
        half = 0.5 * (self.cols - 1) * self.pitch_um, 0.5 * (self.rows - 1) * self.pitch_um
        places: F64 = np.stack([first[0] + half[0] * (1.0 + x), first[1] + half[1] * (1.0 + y)], axis=-1)
        return places

    @property
    def radii_um(self) -> tuple[float, float]:
        """The nearest and the farthest that its photosites are from the axis."""
        low, high = self.places_um(np.array([-1.0, 1.0]), np.array([-1.0, 1.0]))
        return float(np.hypot(*np.maximum(np.maximum(low, -high), 0.0))), float(np.hypot(*np.maximum(-low, high)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Basis:
    """Transfers that stand for all places of a box.

    made_of : (terms, radii, harmonics) what each takes of ``Transfers.harmonics``
    shares  : (terms, along y, along x) of each at the box's Chebyshev places
    cuts    : (terms,) frequency beyond which each is nothing, falling
    """

    made_of: C128
    shares: F64
    cuts: F64

    def weighed(self, box: Box, rows: F64, cols: F64, images: F64) -> F64:
        """Return the sum of terms' images (terms, rows, cols) at rows and columns of a box, some beyond it."""

        def along(count: int, size: int, at: F64) -> F64:
            return cardinal(count, 2.0 * at / (size - 1.0) - 1.0 if size > 1 else np.zeros(at.size))

        down = along(self.shares.shape[1], box.rows, rows)
        across = np.ascontiguousarray(along(self.shares.shape[2], box.cols, cols).T)
        out = np.zeros(images.shape[1:])
        work = functools.partial(add_weighed, images, self.shares, down, across, out)
        shared(len(out), work, least=1 + WEIGHED // max(1, images[:, :1].size))
        return out

    def bends_less(self, box: Box, wave_number: float) -> bool:
        """Whether weights change so little that what they are multiplied by has hardly finer waves then."""
        _, y, x = self.shares.shape
        return all((n - 1) ** 2 <= WIDER * wave_number * 0.5 * size for n, size in ((y, box.rows), (x, box.cols)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """What compares transfers.

    heard   : (sets, frequencies, angles) of the window: what a line of full contrast shows of an error there
    index   : (frequencies,) of ``transfers`` at which they are compared, each ``every`` after the one before
    allowed : of an image
    """

    transfers: Transfers
    heard: F64
    index: np.ndarray
    every: int
    allowed: float

    def _seen(self, places_um: F64) -> tuple[C128, C128]:
        """Return what places take of the transfers, and what they show (places, sets, frequencies, angles)."""
        radius, angle = np.hypot(places_um[:, 0], places_um[:, 1]), np.arctan2(places_um[:, 1], places_um[:, 0])
        radial, turns = self.transfers.radii.weights(radius), self.transfers.turns(angle)
        used = np.flatnonzero(np.abs(radial).max(axis=0) > 0.0)
        some = slice(int(used[0]), int(used[-1]) + 1)
        most, (sets, count, angles) = self.transfers.most, self.heard.shape
        # Radii weigh real and imaginary parts alike: one product for all harmonics.
        made = product(radial[:, some], self._compared[some]).view(complex).reshape(len(radius), -1, 2 * most + 1)
        made *= turns[:, None]
        spectrum = np.zeros((len(places_um), sets * count, 2 * angles), complex)
        spectrum[..., : most + 1], spectrum[..., -most:] = made[..., most:], made[..., :most]
        around = scipy.fft.ifft(spectrum, axis=-1, norm="forward")[..., :angles]
        taken: C128 = radial[:, :, None] * turns[:, None]
        return taken, around.reshape(-1, sets, count, angles) * self.heard

    @cached_property
    def _compared(self) -> F64:
        """Harmonics of the transfers at the frequencies that are compared, as pairs (radii, sets · |f| · harmonics)."""
        own = np.ascontiguousarray(self.transfers.harmonics[:, :, self.index])
        return own.view(np.float64).reshape(len(own), -1)

    def counts(self, boxes: list[Box]) -> tuple[int, int] | None:
        """Return how many places along x and along y are enough for boxes; None: these are too large."""
        found = [1, 1]
        for axis in (0, 1):
            for box in boxes:
                while found[axis] < MOST_PLACES and self._lost(box, axis, found[axis]) > ALONG * self.allowed:
                    found[axis] += 1
                if found[axis] == MOST_PLACES:
                    return None
        return found[0], found[1]

    def _lost(self, box: Box, axis: int, count: int) -> float:
        """Return what interpolation along x or y from so many places loses."""
        between = np.concatenate([-np.cos(np.pi * np.arange(count + 1) / count), [0.3]])
        lost = 0.0
        for other in (-0.9, 0.6):
            at, right = (np.stack([x, np.full(x.size, other)][:: 1 - 2 * axis]) for x in (nodes(count), between))
            shown = self._seen(box.places_um(*np.concatenate([at, right], axis=1)))[1]
            own, its = shown[:count], shown[count:]
            gap = its - np.einsum("pn,nsfa->psfa", cardinal(count, between), own)
            lost = max(lost, float(loudness(gap).max()))
        return lost

    def basis(self, box: Box, counts: tuple[int, int]) -> Basis:
        """Return the transfers that stand for a box."""
        x, y = (axis.ravel() for axis in np.meshgrid(nodes(counts[0]), nodes(counts[1])))
        taken, shown = self._seen(box.places_um(x, y))
        flat, sets, count, angles = shown.shape
        # Real shares only: then each term's image is real.
        left = np.ascontiguousarray(shown).view(np.float64).reshape(flat, -1)
        allowed = LEFT * self.allowed
        shares: list[F64] = []
        makes: list[F64] = []
        terms: list[F64] = []
        loud = loudness(shown)
        while len(terms) < flat and (loud.max() > allowed or between(_as(left, shown), counts) > allowed):
            pick = int(np.argmax(loud))
            size = float(np.sqrt(left[pick] @ left[pick]))
            term = left[pick] / size
            made = np.zeros(flat)
            made[pick] = 1.0
            for share, its in zip(shares, makes, strict=True):
                made -= share[pick] * its
            share = product(left, term[:, None])[:, 0]
            left -= np.multiply.outer(share, term)
            shares.append(share)
            makes.append(made / size)
            terms.append(term)
            loud = loudness(_as(left, shown))
        if not terms:
            return Basis(made_of=taken[:0], shares=np.zeros((0, counts[1], counts[0])), cuts=np.zeros(0))
        largest = np.abs(np.array(shares)).max(axis=1)
        cuts = np.array(
            [
                self._cut(own * term.view(complex).reshape(sets, count, angles), CUT * self.allowed / len(terms))
                for term, own in zip(terms, largest, strict=True)
            ]
        )
        cuts = np.maximum.accumulate(cuts[::-1])[::-1]
        # As far as the first that is nothing: from the last that is not to there they may all be something.
        cuts = np.where(cuts > 0, self.index[0] + self.every * cuts, 0) * self.transfers.step
        return Basis(
            made_of=np.einsum("qp,pkm->qkm", np.array(makes), taken),
            shares=np.array(shares).reshape(-1, counts[1], counts[0]),
            cuts=cuts,
        )

    @staticmethod
    def _cut(term: C128, allowed: float) -> int:
        """Return the first of the compared frequencies from which on a term is nothing; 0: everywhere."""
        beyond = np.cumsum(np.abs(term)[:, ::-1], axis=1)[:, ::-1].max(axis=(0, 2))
        loud = np.flatnonzero(beyond > allowed)
        return int(loud[-1]) + 1 if loud.size else 0


def loudness(shown: C128) -> F64:
    """Return what transfers (n, sets, frequencies, angles), as they are heard, show of a line at the most."""
    most: F64 = np.sqrt(np.square(shown.real) + np.square(shown.imag)).sum(axis=2).max(axis=(1, 2))
    return most


def between(shown: C128, counts: tuple[int, int]) -> float:
    """Return how loud transfers at a box's Chebyshev places are between them, in the loudest directions."""
    each = np.moveaxis(shown, 2, -1).reshape(*counts[::-1], -1, shown.shape[2])
    loudest = np.argsort(np.abs(each).sum(axis=-1).max(axis=(0, 1)))[-LOUDEST:]
    across, down = (cardinal(count, np.linspace(-1.0, 1.0, 2 * count + 1)) for count in counts)
    pairs = np.ascontiguousarray(each[:, :, loudest]).view(np.float64)
    rows = product(down, pairs.reshape(counts[1], -1)).reshape(len(down), counts[0], -1)
    found = np.stack([product(across, row) for row in rows]).reshape(-1, loudest.size, 2 * shown.shape[2])
    found = found.view(complex)
    return float(np.abs(found).sum(axis=-1).max())


def angles_of(most: int) -> int:
    """Return on how many angles of half a circle harmonics are compared."""
    return fast_length(most + 1)


def _as(pairs: F64, shown: C128) -> C128:
    """Return real and imaginary parts in turn as numbers of a shape."""
    numbers: C128 = pairs.view(complex).reshape(shown.shape)
    return numbers
