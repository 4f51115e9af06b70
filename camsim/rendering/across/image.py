"""What differs from the perfect lens over the frame, its transfers and its bands."""

from __future__ import annotations

import functools
import math
import threading
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.kernels import ahead, shared
from camsim.optics.placed import Revolves
from camsim.rendering.across.band_image import BandImage, band_image
from camsim.rendering.across.bands import DIRECTIONS, Band, Listened, bands_of
from camsim.rendering.across.far_reach import far_reach
from camsim.rendering.across.hardest import changes_of
from camsim.rendering.across.places import Box
from camsim.rendering.across.radial_samples import Sampler
from camsim.rendering.across.transfers import SIX, TransferPlan, Transfers
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Progress
from camsim.rendering.fast_length import fast_length
from camsim.rendering.job import Job
from camsim.rendering.spectral import multiples

BOXES_AT_ONCE = 4  # on threads of their own, each with fields of its own; what more there are share their work
EACH = 0.25  # of the transfers' share: what each of their approximations may leave


@dataclass(frozen=True, kw_only=True, eq=False)
class DifferenceImage:
    """The difference behind a lens of revolution; the job's tolerance is its part.

    between : what places that are interpolated may leave
    """

    job: Job
    lens: Revolves
    between: float

    @cached_property
    def signals(self) -> tuple[F64, I64, F64]:
        """Weights (sets, wavelengths) of transfers, each one's channel, and what spectra but the background's take.

        Spectra that are multiples of one another in a channel have one transfer.
        """
        density = self.job.signals.density
        contrast = density[1:] - density[0]
        weights, channel, taken = [], [], []
        for k in range(contrast.shape[1]):
            which, times = multiples(contrast[:, k])
            for own in np.unique(which):
                weights.append(contrast[own, k])
                channel.append(k)
                taken.append(np.where(which == own, times, 0.0))
        return np.array(weights), np.array(channel), np.array(taken).T

    @cached_property
    def contrast(self) -> F64:
        """The most that two sides of an edge differ by, of each set."""
        taken = np.concatenate([np.zeros((1, len(self.signals[1]))), self.signals[2]])
        most: F64 = np.abs(taken[self.job.sides[:, 0]] - taken[self.job.sides[:, 1]]).max(axis=0)
        return most

    @cached_property
    def radii_um(self) -> tuple[float, float]:
        """Where in the frame the window lies."""
        return Box.window(self.job.grid).radii_um

    @cached_property
    def changes(self) -> tuple[F64, F64]:
        """Radii, and how much wavefronts change up to each."""
        return changes_of(self.lens, self.radii_um, float(self.job.signals.wavelength_nm[0]))

    def _heard(self, frequency: F64) -> F64:
        """Return how much of a transfer's error a line shows at frequencies in cycles/pitch, about."""
        return 1.0 / np.square(np.maximum(math.pi * frequency, 1.0))

    @cached_property
    def planned(self) -> TransferPlan:
        """What the lens takes along its radius."""
        job, (weights, _, _) = self.job, self.signals
        sampler = Sampler(
            self.lens,
            job.signals.wavelength_nm,
            weights * self.contrast[:, None],
            self.radii_um,
            EACH * job.budget.allowed("transfers"),
        )
        return TransferPlan(sampler=sampler, pitch_um=job.grid.pitch_um, heard=self._heard)

    @property
    def transfers(self) -> Transfers:
        """The lens along its radius."""
        return self.planned.transfers

    @cached_property
    def listened(self) -> Listened:
        """What lines show."""
        return Listened(transfers=self.transfers, edges=self.job.edges, share=self.job.budget.allowed("near cut"))

    @cached_property
    def bands(self) -> tuple[Band, ...]:
        """The bands, the finest first."""
        job, (weights, _, _) = self.job, self.signals
        extent = job.footprint.extent if job.footprint is not None else 0.0
        far = far_reach(
            self.lens,
            job.system,
            job.signals.wavelength_nm,
            weights * self.contrast[:, None],
            radii_um=self.radii_um,
            pitch_um=job.grid.pitch_um,
            edges=job.edges,
            allowed=job.budget.allowed("far cut"),
        )
        return bands_of(self.listened, extent + far, extent, job.farthest, (job.grid.rows, job.grid.cols))

    @cached_property
    def angles(self) -> int:
        """Points of half a circle from which a six-point look-up keeps its share."""
        transfers, allowed = self.transfers, EACH * self.job.budget.allowed("transfers")
        frequency = transfers.step * np.arange(float(transfers.harmonics.shape[2]))
        size = (np.abs(transfers.harmonics).max(axis=(0, 1)) * self._heard(frequency)[:, None]).max(axis=0)
        m = np.abs(np.arange(-transfers.most, transfers.most + 1))
        count = transfers.most + 1
        while True:
            count = fast_length(count + 1)
            if float(np.sum(size * np.minimum(SIX * (math.pi * m / count) ** 6, 2.0))) <= allowed:
                return count

    @cached_property
    def parts(self) -> tuple[BandImage, ...]:
        """The image of each band."""
        return tuple(ahead(functools.partial(band_image, self), self.bands, len(self.bands)))

    @property
    def held_bytes(self) -> float:
        """What transfers take as they are kept: in two orders, and what lines show of them three times."""
        return self.planned.kept_bytes * (2.0 + 3.0 * DIRECTIONS / self.planned.harmonics)

    def _at_once(self, part: BandImage) -> int:
        """Return how many of a band's boxes fit in memory at a time, on threads of their own."""
        fitting = (MEMORY_LIMIT_BYTES - self.held_bytes) / max(part.box_bytes, 1.0)
        return max(1, min(BOXES_AT_ONCE, len(part.boxes), int(fitting)))

    @property
    def memory_bytes(self) -> float:
        """What it takes besides the image."""
        return self.held_bytes + max(self._at_once(part) * part.box_bytes for part in self.parts)

    def rendered(self, channel: U8, progress: Progress) -> F64:
        """Return the image, each photosite in its own channel."""
        image = np.zeros(channel.shape)
        for part in self.parts:
            part.add_lines(channel, image)
        whole, done, caller = sum(len(part.boxes) for part in self.parts), list[Box](), threading.get_ident()
        for part in self.parts:
            part.prepared()

            def add(first: int, end: int, part: BandImage = part) -> None:
                for box in part.boxes[first:end]:
                    part.add_box(box, channel, image)
                    done.append(box)
                    if threading.get_ident() == caller:
                        progress(len(done) / whole)

            shared(len(part.boxes), add, most=self._at_once(part))
        return image
