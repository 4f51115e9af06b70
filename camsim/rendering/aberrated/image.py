"""The difference's image: lines from their responses, everything else on windows by Fourier transforms."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.kept import cached_property
from camsim.kernels import shared
from camsim.optics.difference import Difference
from camsim.rendering.aberrated.kernels import Lines, Responses, add_lines, mark
from camsim.rendering.aberrated.pattern import ShortPattern
from camsim.rendering.aberrated.settings import Settings
from camsim.rendering.aberrated.window_kernels import Table, add_edges, add_strip
from camsim.rendering.aberrated.windows import Window, windows
from camsim.rendering.engine import Progress
from camsim.rendering.fourier.blocks import Place
from camsim.rendering.fourier.edge_transforms import PRODUCTS, turn_across
from camsim.rendering.fourier.inverse import inverse
from camsim.rendering.fourier.nearby import Nearby, regions_of
from camsim.rendering.fourier.regions import Regions
from camsim.rendering.job import Job, Nodes

SAME_DIRECTION = 1e-13  # of a normal: lines this nearly parallel share a response


@dataclass(frozen=True, kw_only=True, eq=False)
class ShortImage:
    """What is to be seen of a difference; the job's lens is that difference, its tolerance its part."""

    job: Job
    rest: Difference
    nodes: Nodes
    settings: Settings

    @cached_property
    def pattern(self) -> ShortPattern:
        """The pattern, wavelengths fused."""
        density = self.nodes.density
        return ShortPattern(
            rest=self.rest,
            system=self.job.system,
            pitch_um=self.job.grid.pitch_um,
            settings=self.settings,
            wavelength_nm=self.nodes.wavelength_nm,
            contrast=density[1:] - density[0],
            lines=len(self.lines[1]),
            precision=self.job.budget.allowed("short pupil"),
        )

    @cached_property
    def lines(self) -> tuple[Lines, F64]:
        """Edges, and the normals (n, 2) of those that are long enough to be lines for some photosite."""
        edges = self.job.edges
        along, length = edges.end - edges.start, edges.length
        tx, ty = along[:, 0] / length, along[:, 1] / length
        long = length > 2.0 * self.settings.near
        response = np.full(len(edges), -1)
        normals, index = np.unique(
            np.round(np.stack([-ty, tx], axis=1)[long] / SAME_DIRECTION), axis=0, return_inverse=True
        )
        response[long] = index.ravel()
        x, y = (np.ascontiguousarray(axis) for axis in edges.start.T)
        return Lines(x, y, tx, ty, length, response, self.job.pair), normals * SAME_DIRECTION

    def responses(self) -> Responses:
        """Return what lines show, one for each normal, pair and channel."""
        of_sets = self.pattern.responses(self.lines[1])
        weights = self.pattern.sets[1]
        of_spectra = np.concatenate([np.zeros((1, *weights.shape[1:])), weights])  # the background's are none
        of_pairs = of_spectra[self.job.sides[:, 0]] - of_spectra[self.job.sides[:, 1]]
        cells = np.einsum("pkb,obcx->opkcx", of_pairs, of_sets)
        return Responses(np.ascontiguousarray(cells), self.settings.near, self.settings.step)

    @cached_property
    def marked(self) -> U8:
        """The photosites (rows, cols) that see an end, or an edge that is no line."""
        grid = self.job.grid
        marked = np.zeros((grid.rows, grid.cols), np.uint8)
        origin, lines = grid.first_centre, self.lines[0]
        shared(grid.rows, functools.partial(mark, origin, lines, self.settings.near, marked))
        return marked

    @cached_property
    def windows(self) -> list[Window]:
        """Windows that hold them."""
        return windows(self.marked, self.settings.grain, self.settings.side)

    def rendered(self, channel: U8, progress: Progress) -> F64:
        """Return the difference's image, each photosite in its own channel."""
        image = np.zeros(channel.shape)
        if len(self.lines[1]):
            origin, lines, responses, marked = self.job.grid.first_centre, self.lines[0], self.responses(), self.marked
            shared(len(image), functools.partial(add_lines, origin, lines, responses, channel, marked, image))
        for done, window in enumerate(self.windows):
            part = slice(window.row, window.row + window.rows), slice(window.col, window.col + window.cols)
            values = self._in_window(window, channel[part])
            here = self.marked[part] == 1
            image[part][here] = values[here]
            progress((done + 1) / len(self.windows))
        return image

    @cached_property
    def _nearby(self) -> Nearby:
        return Nearby(edges=self.job.edges)

    def _in_window(self, window: Window, channel: U8) -> F64:
        tile = self.settings.tile(*window)
        x0, y0 = self.job.grid.first_centre
        seen = self._nearby.seen(tile, (x0 + window.col, y0 + window.row))
        values = np.zeros(channel.shape)
        if not len(seen):
            return values
        spectra, regions = regions_of(seen, tile, self.job.tolerance)
        present = np.unique(channel)
        weights = np.ascontiguousarray(self.pattern.sets[1][spectra - 1][:, present])
        table = Table(self.pattern.fields, weights, regions.areas, self.settings.period, self.settings.cut)
        total = np.zeros((present.size, 2, *tile.sums))
        self._add(total, table, regions)
        for k, (real, imaginary) in zip(present, total, strict=True):
            mine = channel == k
            values[mine] = inverse(real + 1j * imaginary, tile)[mine]
        return values

    def _add(self, total: F64, table: Table, regions: Regions) -> None:
        """Add a window's regions, transformed and multiplied, to the photosites' own grid of frequencies."""
        count, targets = table.fields.shape[4], total.shape[2] // 2 + 1
        products = 2.0 * count * count / targets
        if regions.corners is None:
            for strip, whole in regions.strips():
                transforms = np.stack(whole)
                work: Callable[..., None] = functools.partial(add_strip, total, table, strip.first_j, transforms)
                shared(targets, work, least=math.ceil(PRODUCTS / products))
            return
        corners = regions.corners
        across = np.empty((2, len(corners.points), count))
        row = Place(0, 0, count, 1, table.period, table.period, table.cut, 0, 0, 1)
        turn_across(row, corners.points, across, 0, len(corners.points))
        work = functools.partial(add_edges, total, table, corners, across)
        shared(targets, work, least=math.ceil(PRODUCTS / (products * len(corners.points))))
