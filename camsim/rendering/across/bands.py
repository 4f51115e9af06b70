"""What differs from the perfect lens, in bands of frequencies: the finest are short, the smoothest go farthest.

A pattern's tail comes from the corner that its transfer has at frequency 0. A smooth window takes that part out: it
falls from 1 at 0 to 0 at its end, and its slope is a Kaiser–Bessel window, of all of that width nearly the shortest on
the other side. What it leaves is nothing about 0, and short; what it takes goes on for hundreds of photosites, and
needs few frequencies. A second window of a quarter of the width parts that again, and so on: each band reaches four
times as far as the one before with a quarter of its frequencies, and what is smooth enough is made on every second,
fourth … photosite and interpolated between them.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kept import cached_property
from camsim.products import complex_product
from camsim.rendering.aberrated.settings import sighted
from camsim.rendering.across.ends import Ends
from camsim.rendering.across.filling import ALL, coarsest
from camsim.rendering.across.places import WIDER
from camsim.rendering.across.transfers import SIX, Transfers
from camsim.rendering.across.unfollowed import unfollowed
from camsim.rendering.edges import Edges
from camsim.rendering.fast_length import fast_length
from camsim.rendering.fourier.taper import taper, taper_margin, tapered
from camsim.rendering.fourier.tile import Tile

ENDS = (0.72, 0.18, 0.045)  # of the windows, cycles/pitch
WORTH = 2.0  # times a band's reach, that what is left of it goes on: from here on it is parted again
DIRECTIONS = 16  # in which lines are looked at
FINER = 26.0  # frequencies in a window, of what a line shows
LINE = 4096  # points of it
ENDS_OF = 2  # of the transfers whose lines are heard the farthest, ends of edges are listened to
SHORT, CUT = 0.25, 0.033  # of the near bands' share: the reach of each of three, the end of each window
PEAKS = 1.1  # times the highest of a line's points: eight of them are in its finest wave
FINER_STEPS = (8, 12, 16, 24, 32, 48, 64, 96, 128)  # of look-ups in responses: in the finest wave
LOOKED_UP = 0.05  # of the share, by these
BENT = 0.05  # of it: what a run lacks, and what the square of its bend shows; and what chords leave of tiles' edges
TIMES = {"near": 5.0, "smooth": 6.0, "far": 4.0}  # the reach: sides of tiles
GROUPS = {"near": 4, "smooth": 3, "far": 1}  # tiles along a side that have places in common
LEAST_SIDE, LEAST_REACH = 48, 1.0  # pitches


def passed(frequency: F64, end: float, sharpness: float) -> F64:
    """Return what passes a window that ends there, of a sharpness (β): nothing passes 0, all passes ∞."""
    if end in (0.0, math.inf):
        return np.full(frequency.shape, float(end > 0.0))
    return tapered(frequency, 0.0, end, taper(sharpness))


def between(frequency: F64, low: float, high: float, sharpness: float) -> F64:
    """Return what passes one window and not another."""
    return passed(frequency, high, sharpness) - passed(frequency, low, sharpness)


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """Frequencies between two windows, and how they are transformed.

    low, high : ends of the windows, cycles/pitch, of a ``sharpness``;  cut: from where on nothing is heard of the upper
    finer  : steps of what lines show in the finest wave
    reach  : as far as a line is heard, footprint included, pitches
    sight  : as far as there are edges to be heard;  from a period on, less this, all must be quiet
    side   : of a tile, photosites
    filling: weights (step, points) of what fills in all others;  period: of those that are transformed, every step-th
    box    : photosites along what has places in common
    """

    low: float
    high: float
    sharpness: float
    cut: float
    finer: int
    reach: float
    sight: float
    side: int
    period: int
    box: int
    filling: F64 = field(repr=False, compare=False)

    def with_side(self, side: int) -> Band:
        """Return the same band in other tiles."""
        # Even: every second photosite has a period of its own.
        period = 2 * fast_length(math.ceil(0.5 * (self.steps(side) + (self.reach + self.sight) / self.step)), real=True)
        return dataclasses.replace(self, side=side, period=period)

    def window(self, frequency: F64) -> F64:
        """Return what the band takes of frequencies."""
        return between(frequency, self.low, self.high, self.sharpness)

    @property
    def step(self) -> int:
        """Photosites from one to the next that is transformed."""
        return len(self.filling)

    @property
    def before(self) -> int:
        """Steps before a tile's first photosite that are transformed as well."""
        return max(0, int(self.filling.shape[1]) // 2 - 1)

    def steps(self, count: int) -> int:
        """Return how many are transformed for so many photosites in a row."""
        return (count - 1) // self.step + int(self.filling.shape[1])

    def tile(self, rows: int, cols: int) -> Tile:
        """Return photosites as the transforms take them: lengths are steps."""
        place, reach = (0, 0, self.steps(rows), self.steps(cols)), self.reach / self.step
        return Tile.square(
            place, inner=reach, outer=reach, period=self.period, cut=self.cut * self.step, near=self.sight / self.step
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Listened:
    """What lines show of a lens along its radius, each transfer as loud as it is given.

    share : of an image, for all bands but the one that goes farthest, and for the ends of windows
    """

    transfers: Transfers
    edges: Edges
    share: float

    @property
    def sharpness(self) -> float:
        """Of the windows: their side lobes are what they may leave."""
        return taper_margin(self.share)[1]

    @cached_property
    def _lines(self) -> tuple[F64, C128]:
        """Frequencies, and transfers (n, radii · sets · directions) across lines at them."""
        transfers = self.transfers
        frequency = transfers.step * np.arange(float(transfers.harmonics.shape[2]))
        return frequency, self._around(0)

    @cached_property
    def _turned(self) -> tuple[C128, C128]:
        """Their first and third derivatives by the direction."""
        return self._around(1), self._around(3)

    def _around(self, order: int) -> C128:
        kept, most = self.transfers.harmonics, self.transfers.most
        m = np.arange(-most, most + 1)
        times = np.exp(1j * math.pi / DIRECTIONS * np.multiply.outer(m, np.arange(DIRECTIONS)))
        times *= (1j * m[:, None]) ** order
        found = np.empty((kept.shape[2], *kept.shape[:2], DIRECTIONS), complex)
        for k, own in enumerate(kept):  # copies of all at once take several times as much
            each = complex_product(own.reshape(-1, m.size), times)
            found[:, k] = np.moveaxis(each.reshape(*own.shape[:2], -1), 0, 1)
        return found.reshape(kept.shape[2], -1)

    def reach(self, low: float, high: float) -> float:
        """Return how far lines, and ends of edges, are heard of what lies between two windows, pitches."""
        known, lines = self._lines
        frequency = known
        if low / FINER < self.transfers.step:
            frequency = np.arange(0.0, min(high, float(known[-1])), low / FINER)
            known = known[: max(int(np.searchsorted(known, 2.0 * high)), 3) + 1]
        lines, step = _resampled(known, lines, frequency), frequency[1]
        window = between(frequency, low, high, self.sharpness)
        weight = np.zeros(frequency.size)
        weight[1:] = window[1:] * step / frequency[1:]
        heard, of_each = np.zeros(LINE // 2), []
        for own in lines.T:
            shown = np.abs(scipy.fft.irfft(own * weight / (2j * math.pi), n=LINE, norm="forward"))
            both = np.maximum(shown[: LINE // 2], shown[:0:-1][: LINE // 2])
            heard = np.maximum(heard, both)
            of_each.append(int(np.flatnonzero(both > SHORT * self.share).max(initial=0)))
        beyond = np.maximum.accumulate(heard[::-1])[::-1]
        place = np.arange(LINE // 2) / (LINE * step)
        farthest = np.max(np.reshape(of_each, (-1, DIRECTIONS)), axis=1)  # of each radius and set
        kept = self.transfers.harmonics.reshape(farthest.size, *self.transfers.harmonics.shape[2:])
        loudest = [
            Ends(frequency, _resampled(known, kept[k], frequency), window)
            for k in np.argsort(-farthest, kind="stable")[:ENDS_OF].tolist()
        ]

        def reach_of(lines: float) -> float:
            allowed = SHORT * self.share / lines
            loud = np.flatnonzero(beyond > allowed)
            reach = max(LEAST_REACH, float(place[min(loud[-1] + 1, place.size - 1)]) if loud.size else 0.0)
            return max(reach, *(ends.reach(allowed, reach) for ends in loudest))

        return sighted(self.edges, reach_of)

    def cut(self, high: float) -> float:
        """Return from where on what passes a window shows nothing, cycles/pitch."""
        frequency, size = self._shown(high)
        beyond = np.cumsum(size[::-1])[::-1]
        return float(frequency[min(int(np.sum(beyond > CUT * self.share)) + 1, frequency.size - 1)])

    def filling(self, high: float, cut: float) -> F64:
        """Return weights (step, points) that fill in what passes a window, made on as few photosites as they allow."""
        frequency, size = self._shown(high)
        size[0] = size[1]
        heard = frequency < cut + frequency[1]
        wider = 1.0 + WIDER
        return coarsest(wider * frequency[heard], size[heard] / (wider * frequency[1]), CUT * self.share)

    def finer(self, high: float, cut: float) -> int:
        """Return how many steps of what a line shows there are in the finest wave, for a six-point look-up."""
        frequency, size = self._shown(high)
        for steps in FINER_STEPS:
            lost = np.minimum(SIX * (2.0 * math.pi * frequency / (steps * cut)) ** 6, 2.0)
            if float(np.sum(size * lost)) <= LOOKED_UP * self.share:
                return steps
        raise unfollowed(f"look-ups in {steps} steps of a wave")

    def apart(self, low: float, high: float) -> float:
        """Return how far edges may be from where they belong, pitches, of what passes between two windows."""
        frequency, lines = self._lines
        most = np.abs(lines).max(axis=1) * between(frequency, low, high, self.sharpness)
        return BENT * self.share / max(float(2.0 * frequency[1] * np.sum(most[1:])), 1e-300)

    def bent(self, low: float, high: float) -> F64:
        """Return how far a line may be from where it belongs, half of the square of that, and how fast its bend grows.

        A line that is t³·twist/6 away shows twist/48π³ of ∂³M/∂k³, k along it: of what passes between two windows.
        """
        (frequency, lines), (once, thrice) = self._lines, self._turned
        f = frequency[1:, None]
        window = between(f, low, high, self.sharpness)
        shown = np.zeros_like(lines)
        shown[1:] = lines[1:] * window * frequency[1]
        slope, bend = (
            PEAKS * max(float(np.abs(scipy.fft.irfft(own * times, n=LINE, norm="forward")).max()) for own in shown.T)
            for times in (1.0, 2j * math.pi * frequency)
        )
        rising = np.gradient(once[1:] * window, frequency[1], axis=0)
        along = np.abs((thrice[1:] - 2.0 * once[1:]) * window / f**3 + 3.0 * rising / f**2).max(axis=1)
        moved = slope, bend, 2.0 * frequency[1] * np.sum(along) / (48.0 * math.pi**3)
        allowed: F64 = BENT * self.share / np.maximum(moved, 1e-300)
        return allowed

    def _shown(self, high: float) -> tuple[F64, F64]:
        """Return frequencies, and the most that lines show at each."""
        frequency, lines = self._lines
        size = np.zeros(frequency.size)
        window = passed(frequency[1:], high, self.sharpness)
        size[1:] = np.abs(lines[1:]).max(axis=1) * window / (math.pi * np.arange(1, size.size))
        return frequency, size


def _resampled(known: F64, values: C128, frequency: F64) -> C128:
    """Return values (n, …) at other frequencies than those (m,) at which the first of them are known."""
    if frequency is known:
        return values
    found: C128 = scipy.interpolate.CubicSpline(known, values[: known.size])(frequency)
    return found


def bands_of(listened: Listened, far: float, extent: float, span: float, shape: tuple[int, int]) -> tuple[Band, ...]:
    """Return the bands of a window of (rows, cols), the finest first.

    far : as far as lines are heard at all, footprint (``extent``) included
    span : the farthest that an edge is from any of the window's photosites
    """
    found: list[Band] = []
    high = math.inf
    for low in (*ENDS, 0.0):
        reach = extent + listened.reach(low, high) if low > 0.0 else far
        if found and far <= WORTH * reach:
            low, reach = 0.0, far
        cut = listened.cut(high)
        name = "near" if not found else "smooth" if low > 0.0 else "far"
        side, group = max(LEAST_SIDE, math.ceil(TIMES[name] * reach)), GROUPS[name if len(found) < 2 else "far"]
        side = max(-(-count // max(1, round(count / side))) for count in shape)  # the window is whole tiles
        group = 1 if side >= max(shape) else group
        sight, box, filling = min(reach, span), side * group, listened.filling(high, cut) if found else ALL
        band = Band(
            low=low, high=high, sharpness=listened.sharpness, cut=cut, finer=listened.finer(high, cut),
            reach=reach, sight=sight, side=side, period=0, box=box, filling=filling,
        )  # fmt: skip
        found.append(band.with_side(side))
        if low == 0.0:
            break
        high = low
    return tuple(found)
