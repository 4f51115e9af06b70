"""Bent edges as chords and slivers: a perfect lens renders few long edges in closed form, and what lies beside them.

Distortion bends an edge by thousandths of a pitch, and yet it takes a hundred straight sides to be followed. Between a
chord and these lies a sliver of height h(t), which shows ∫ h(t)·P(x − q(t)) dt, q half way across it and P what a
photosite sees of a point: all but h³/24·P″. P need be known to few digits, as it counts h times only: it is looked up
near by, and is its mean tail λN/π³r³ farther off.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.rendering.bending import TAIL
from camsim.rendering.across.chords import Chords, chords_of, heights
from camsim.rendering.across.sliver_kernels import BLOCK, Pattern, Slivers, add_slivers
from camsim.rendering.job import Job, Nodes
from camsim.rendering.spectral import multiples

NEAR, BLURS = 8.0, 12.0  # pitches, and blurs more than the footprint: from here on the tail stands for the pattern
PERIOD = 3.0  # times that: the pattern's own copies are as far again
APART, TURN = 0.25, 0.8  # nodes: pitches, and of the finest wave
FINER, FINEST = 6.0, 16.0  # steps of the pattern's table: in the finest wave, and in a pitch at the least
LARGEST = 1024  # steps of a table along a side
KNOWN = 5e-5  # of what a line shows: more than looking up was seen to be wrong by
HIGHEST = 5e-3  # pitches: of a sliver that is seen as a whole
LINES = 4  # that are in sight
GREGORY = np.array([3.0 / 8.0, 7.0 / 6.0, 23.0 / 24.0])  # weights of the first nodes of a rule that is even elsewhere


def straightened(job: Job, allowed: float) -> Chords:
    """Return a job's edges with chords for all that bends so little that ``allowed`` of an image keeps slivers."""
    near = _near(job)
    if not len(job.edges) or 2.0 * near * _per_pitch(job) > LARGEST:
        return Chords(edges=job.edges, which=np.zeros(0, np.int64), points=())
    return chords_of(job.edges, min(HIGHEST, allowed / (2.0 * LINES * KNOWN * math.sqrt(2.0))), near)


def _near(job: Job) -> float:
    return max(NEAR, BLURS * float(job.blur.max()) + job.extent)


def _cut(job: Job) -> float:
    return 1.0 / float(job.blur.min())


def _per_pitch(job: Job) -> float:
    return float(max(FINEST, math.ceil(FINER * _cut(job))))


@dataclass(frozen=True, kw_only=True, eq=False)
class SliverImage:
    """What slivers add to the image of chords.

    job   : of the chords, behind the perfect lens;  pair: of each chord (n,)
    nodes : its wavelengths;  allowed: of an image
    """

    job: Job
    points: tuple[F64, ...]
    pair: I64
    nodes: Nodes
    allowed: float

    @cached_property
    def _tabled(self) -> tuple[F64, I64, F64]:
        """Weights (tables, channels, wavelengths), each pair's table, and how many times that it is."""
        weights = self.nodes.weights
        which, times = multiples(weights.reshape(len(weights), -1))
        own, alike = np.unique(which, return_inverse=True)
        return weights[own], alike.ravel(), times

    def _laid(self) -> Slivers:
        """Return the chords and their nodes: of each what lies within its reach of the window."""
        _, alike, times = self._tabled
        apart = min(APART, TURN / _cut(self.job))
        longest, extent = float(self.job.blur.max()), self.job.extent
        grid, frames, nodes, blocks = self.job.grid, [], [], []
        sides = np.array([grid.cols - 1, grid.rows - 1])
        corners = np.array(grid.first_centre) + sides * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
        for own, pair in zip(self.points, self.pair, strict=True):
            along, height = heights(own)
            tx, ty = (own[-1] - own[0]) / along[-1]
            off = math.sqrt(2.0 * LINES * float(np.abs(height).max()) * longest / (TAIL * self.allowed))
            seen = np.einsum("ni,i->n", corners - own[0], (tx, ty))
            # A half-plane's side is 10⁹ pitches long.
            begin, end = max(0.0, seen.min() - extent - off), min(along[-1], seen.max() + extent + off)
            length = max(end - begin, 0.0)
            count = max(2 * GREGORY.size, math.ceil(length / apart))
            t = begin + length * np.arange(count + 1) / count
            h = np.interp(t, along, height)
            rule = np.ones(count + 1)
            rule[: GREGORY.size], rule[-GREGORY.size :] = GREGORY, GREGORY[::-1]
            # What lies between has the spectrum to the right in place of the one to the left.
            light = -float(times[pair]) * length / count * rule * h
            x, y = own[0, 0] + t * tx - 0.5 * h * ty, own[0, 1] + t * ty + 0.5 * h * tx
            frames.append([own[0, 0] + begin * tx, own[0, 1] + begin * ty, tx, ty, length, extent + off])
            nodes.append(np.stack([x, y, light]))
            starts = np.arange(0, count + 1, BLOCK)
            many = np.diff(np.append(starts, count + 1))
            blocks.append(
                np.stack([*(np.add.reduceat(part, starts) / many for part in (x, y)), np.add.reduceat(light, starts)])
            )
        return Slivers(
            frame=np.array(frames),
            first=np.cumsum([0, *(own.shape[1] for own in nodes)]),
            alike=alike[self.pair],
            nodes=np.concatenate(nodes, axis=1),
            first_block=np.cumsum([0, *(own.shape[1] for own in blocks)]),
            blocks=np.concatenate(blocks, axis=1),
        )

    def _pattern(self) -> Pattern:
        """Return what a photosite sees of a point."""
        job, (weights, _, _), nm = self.job, self._tabled, self.nodes.wavelength_nm
        near, per = _near(job), int(_per_pitch(job))
        period = math.ceil(PERIOD * near)
        most = math.floor(_cut(job) * period)
        index = np.arange(-most, most + 1)
        frequency = index / (period * job.grid.pitch_um)
        fx, fy = frequency[:, None], frequency
        lens = np.zeros((*weights.shape[:2], index.size, index.size))
        for k, each_nm in enumerate(nm.tolist()):
            lens += weights[:, :, k, None, None] * job.system.lens.otf(fx, fy, each_nm)
        count = period * per
        spectrum = np.zeros((*weights.shape[:2], count, count), complex)
        spectrum[..., index[:, None], index] = lens * job.system.footprint_otf(fx, fy)
        pattern = scipy.fft.ifft2(spectrum, norm="forward").real / period**2
        half = math.ceil((near + 2.0) * per)
        around = np.arange(-half, half + 1) % count
        tail = weights @ job.blur_at(nm) / math.pi**3
        return Pattern(np.ascontiguousarray(pattern[..., around[:, None], around]), float(per), near, tail)

    def add(self, channel: U8, image: F64) -> None:
        """Add it, each photosite in its own channel."""
        if not self.points:
            return
        add = functools.partial(add_slivers, self.job.grid.first_centre, self._laid(), self._pattern(), channel, image)
        shared(len(image), add)
