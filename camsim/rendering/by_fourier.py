"""The Fourier engine (fourier.py), prepared for a job; what judges it."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, I64, U8
from camsim.errors import UnsupportedError
from camsim.optics import OpticalSystem
from camsim.rendering.by_boundary import RoundLens
from camsim.rendering.cost import SET_UP_SECONDS, Cost
from camsim.rendering.footprint import Footprint
from camsim.rendering.fourier import FINEST, check_tolerance, fourier_cost, fourier_image
from camsim.rendering.hardest import SHARE_OF_TIME
from camsim.rendering.job import Job, Nodes
from camsim.rendering.patterns import AIRY
from camsim.rendering.plan import quiet_distance
from camsim.rendering.run import Progress
from camsim.rendering.spotcheck import SHARE
from camsim.rendering.work import Work

WINDOW = 3  # photosites along a side
FEWEST = 2  # photosites that are checked singly: a transform's errors are everywhere, no photosite is a case of its own
RIM = 2  # more on every side of a window: a grid that is one window has other numbers in its check all the same
RINGS_SHARE = 1.0 / 6.0  # of the tolerance, as of the boundary engine
WINDOWS_SHARE = 0.5  # of an image's time, for the windows of the check


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierRun:
    """Any lens and any photosite.

    lens : what checks a round lens by the path of ``spotcheck``. None for others, or where the tolerance is below what
           that path can judge: then the engine judges itself, by other numbers throughout. Small windows have another
           period, another taper, another band and other wavelength nodes than the whole grid, and a tolerance of SHARE;
           what the two have in common are the transfer functions and the transform of an edge.
    """

    job: Job
    nodes: Nodes

    @classmethod
    def prepare(cls, job: Job, samples: int | None) -> FourierRun:
        """Choose nodes; ``samples`` must be None."""
        if samples is not None:
            raise UnsupportedError("samples: fourier takes none; only importance takes a number")
        check_tolerance(job.tolerance)
        return cls(job=job, nodes=_nodes(job, job.tolerance))

    @functools.cached_property
    def check_nodes(self) -> Nodes:
        """Wavelengths of the check."""
        return _nodes(self.job, SHARE * self.job.tolerance)

    @functools.cached_property
    def lens(self) -> RoundLens | None:
        """What checks a round lens; made when it is needed."""
        return RoundLens.prepare(self.job) if self._judged else None

    @property
    def _judged(self) -> bool:
        job = self.job
        return job.pattern is not None and job.footprint is not None and job.tolerance >= job.pattern.finest

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @property
    def cost(self) -> Cost:
        """What one image takes, the check included."""
        seconds, memory_bytes, _ = self._expected
        seconds *= 1.0 + (SHARE_OF_TIME if self._judged else WINDOWS_SHARE)
        return Cost(seconds=SET_UP_SECONDS + seconds, memory_bytes=memory_bytes)

    @functools.cached_property
    def _expected(self) -> tuple[float, float, float]:
        job, grid = self.job, self.job.grid
        return fourier_cost(
            start=job.start,
            end=job.end,
            density=self.nodes.density,
            wavelength_nm=self.nodes.wavelength_nm,
            system=job.system,
            pitch_um=grid.pitch_um,
            origin=grid.first_centre,
            channel=np.broadcast_to(np.uint8(0), (grid.rows, grid.cols)),
            tolerance=job.tolerance,
        )

    def work(self, images: int) -> Work:
        """Count the work of ``images`` images."""
        grid = self.job.grid
        return Work(
            edges=self.job.edges,
            wavelength_nodes=self.wavelengths,
            channels=images,
            photosites=images * grid.rows * grid.cols,
            frequencies=images * round(self._expected[2]),
        )

    def of(self, job: Job) -> FourierRun:
        """Return the same wavelengths for other edges."""
        return FourierRun(job=job, nodes=job.nodes_like(self.nodes))

    def bands(self, channel: U8, progress: Progress) -> Iterator[F64]:
        """Yield the image as one band: its last row is known no sooner than its first."""
        yield self._image(self.nodes, self.job.grid.first_centre, channel, self.job.tolerance, progress)

    def hardest(self, render_seconds: float | None = None) -> tuple[I64, I64]:
        """Return the photosites of ``spotcheck``; else windows about a corner and about the middle of an edge."""
        if self.lens is not None:
            return self.lens.hardest(self._expected[0] if render_seconds is None else render_seconds, FEWEST)
        job, grid = self.job, self.job.grid
        x0, y0 = grid.first_centre
        middle = np.array([x0 + 0.5 * (grid.cols - 1), y0 + 0.5 * (grid.rows - 1)])
        half = 0.5 * np.array([grid.cols, grid.rows])
        places = [points[np.argmin(np.abs((points - middle) / half).max(axis=1))] for points in (job.start, self._mid)]
        return windows(np.array(places), grid.rows, grid.cols, (x0, y0))

    def reference(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Compute photosites again."""
        if self.lens is not None:
            return self.lens.reference(rows, cols, sets)
        x0, y0 = self.job.grid.first_centre
        values = np.empty(rows.size)
        size = min(WINDOW, self.job.grid.rows) * min(WINDOW, self.job.grid.cols)
        for first in range(0, rows.size, size):
            part = slice(first, first + size)
            row, col = int(rows[part].min()), int(cols[part].min())
            shape = (int(rows[part].max()) - row + 1, int(cols[part].max()) - col + 1)
            window = self._image(
                self.check_nodes,
                (x0 + col - RIM, y0 + row - RIM),
                np.pad(sets[part].reshape(shape), RIM, mode="edge"),
                max(SHARE * self.job.tolerance, FINEST),
                lambda done: None,
            )
            values[part] = window[RIM:-RIM, RIM:-RIM].ravel()
        return values

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None

    @property
    def _mid(self) -> F64:
        middles: F64 = 0.5 * (self.job.start + self.job.end)
        return middles

    def _image(
        self, nodes: Nodes, origin: tuple[float, float], channel: U8, tolerance: float, progress: Progress
    ) -> F64:
        job = self.job
        return fourier_image(
            start=job.start,
            end=job.end,
            left=job.left,
            right=job.right,
            density=nodes.density,
            base=job.base,
            wavelength_nm=nodes.wavelength_nm,
            system=job.system,
            pitch_um=job.grid.pitch_um,
            origin=origin,
            channel=channel,
            tolerance=tolerance,
            progress=progress,
        )


def windows(places: F64, rows: int, cols: int, first_centre: tuple[float, float]) -> tuple[I64, I64]:
    """Return rows and columns of small windows of a grid about ``places`` (n, 2), one window after the other."""
    tall, wide = min(WINDOW, rows), min(WINDOW, cols)
    row = np.clip(np.round(places[:, 1] - first_centre[1]) - tall // 2, 0, rows - tall).astype(np.int64)
    col = np.clip(np.round(places[:, 0] - first_centre[0]) - wide // 2, 0, cols - wide).astype(np.int64)
    own = np.unique(np.stack([row, col], axis=1), axis=0)
    down, across = np.divmod(np.arange(tall * wide), wide)
    return (own[:, :1] + down).ravel(), (own[:, 1:] + across).ravel()


def _nodes(job: Job, tolerance: float) -> Nodes:
    """Return wavelengths that follow the rings of the spectrum as far as these are heard.

    Farther out they need not be right, but must be as quiet: a few wavelengths come back into step where the spectrum
    does not, and then more are taken. A lens that is not round is taken for an Airy pattern of the same width on a
    point: no pupil's rings exceed those by much.
    """
    blur, span, allowed = job.blur, job.span, RINGS_SHARE * job.tolerance
    if job.pattern is not None and job.footprint is not None:
        pattern, footprint = job.pattern, job.footprint
    else:
        pattern, footprint = AIRY, Footprint.of(OpticalSystem(lens=job.system.lens), job.grid.pitch_um)
    spread = 2.0 * math.pi * float(1.0 / blur.min() - 1.0 / blur.max())
    followed = quiet_distance(pattern, blur, job.shares, footprint, allowed, front="line", within=span)
    while True:
        nodes = job.nodes(phase=spread * followed, tolerance=tolerance)
        count = nodes.wavelength_nm.size
        if count == blur.size or followed >= span:
            return nodes
        shares, at_nodes = nodes.weights.reshape(-1, count), job.blur_at(nodes.wavelength_nm)
        heard = quiet_distance(pattern, at_nodes, shares, footprint, allowed, front="line", within=span)
        if heard <= followed:
            return nodes
        followed = min(1.4 * followed, span)
