"""A lens of revolution as a plan: the perfect lens by edges in closed form, and what differs, one image for all places.

    I(x) = (Airy ∗ scene)(x) + Σ_q u_q(x)·(T_q ∗ scene)(x)

The scene is mapped by the distortion before any of it (bending.py). Each photosite gathers with the pattern of its own
place; the check recomputes photosites with just that.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

from camsim.arrays import F64, I64, U8
from camsim.kept import cached_property
from camsim.optics.airy import Airy
from camsim.optics.difference import Split
from camsim.optics.placed import Revolves
from camsim.rendering.across.decided import bent_sides
from camsim.rendering.across.image import DifferenceImage
from camsim.rendering.across.place_samples import first_nodes
from camsim.rendering.across.radial_samples import TooLong
from camsim.rendering.across.slivers import SliverImage, straightened
from camsim.rendering.auto import BOUNDARY
from camsim.rendering.boundary.engine import BoundaryPlan
from camsim.rendering.budget import CLOSED_PART, PLACES_PART, ErrorBudget
from camsim.rendering.engine import MEMORY_LIMIT_BYTES, Cost, Decision, Marks, Progress, added, one_by_one
from camsim.rendering.job import Job, Nodes
from camsim.rendering.work import Work
from camsim.repeated import Channels

FEWEST = 4  # photosites checked, each with a pattern of its own
SECONDS, EACH_TRANSFER = 0.1, 5e-3  # of the transfers along the radius: of any, and of each place and wavelength
WAVELENGTHS = 44  # as many of them stand for all that there are
CHECKED, CHECKED_COLOUR, CHECKED_WAVE, CHECKED_TURN = 0.07, 0.012, 1e-3, 1.35e-9  # of a photosite that is checked
CHECKED_OVERLAP = 5.5e-9  # and of a node of an overlap that its search begins with
FEWEST_RADII, LEAST_SEARCH = 8, 0.05  # of transfers; of what a search is expected to take, at the least
EACH_FREQUENCY, EACH_PHOTOSITE = 5e-7, 2e-7  # seconds: of the scene and of some fifteen terms, and of tiles' periods
EACH_PIECE, EACH_CHORD = 3e-3, 2e-3  # of a run's responses, and of slivers
EACH_KEPT = 3e-8  # of a byte of transfers, which are looked at for bands, places and terms: 2e-8 … 6e-8 were measured


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldPlan:
    """A job behind a lens of revolution.

    job    : of the whole window, behind the lens of the axis
    closed : what renders the perfect lens, slivers: and what lies between bent edges and the chords that this takes
    image  : the difference
    """

    job: Job
    closed: BoundaryPlan
    slivers: SliverImage
    image: DifferenceImage

    @classmethod
    def of_job(cls, job: Job, lens: Revolves) -> FieldPlan:
        """Plan a job whose edges are bent already."""
        parts = dataclasses.replace(_perfect(job, lens), tolerance=PLACES_PART * job.tolerance)
        rest = dataclasses.replace(parts, tolerance=(1.0 - CLOSED_PART) * parts.tolerance)
        budget = ErrorBudget(job.tolerance)
        between, slivers = budget.allowed("between places"), budget.allowed("slivers")
        straight = straightened(parts, slivers)
        closed = BOUNDARY.plan(parts.with_edges(straight.edges).round_part)
        return cls(
            job=job,
            closed=closed,
            slivers=SliverImage(
                job=closed.job,
                points=straight.points,
                pair=closed.job.pair[straight.which],
                nodes=closed.nodes,
                allowed=slivers,
            ),
            image=DifferenceImage(job=rest, lens=lens, between=between),
        )

    @property
    def perfect(self) -> Job:
        """The job behind the perfect lens alone, for the check: it transforms windows where integrals are dear."""
        lens = self.image.lens
        return _perfect(self.job.behind(Airy(f_number=lens.f_number)), lens)

    @property
    def marks(self) -> Marks:
        """Where the perfect lens changes its ways, and the near band ends."""
        return dataclasses.replace(self.closed.marks, reach=self.image.bands[0].reach)

    @property
    def fewest(self) -> int:
        """How many photosites are checked whatever it takes."""
        return FEWEST

    @property
    def nodes(self) -> Nodes:
        """Wavelengths of the perfect lens."""
        return self.closed.nodes

    @property
    def wavelengths(self) -> int:
        """Number of wavelength nodes."""
        return self.nodes.wavelength_nm.size

    @cached_property
    def frequencies(self) -> float:
        """Frequencies of all tiles."""
        return sum(part.tiles * part.band.tile(part.band.side, part.band.side).points for part in self.image.parts)

    @property
    def _colours(self) -> int:
        return min(self.job.signals.wavelength_nm.size, WAVELENGTHS)

    @property
    def each_checked_seconds(self) -> float:
        """What the check of one photosite takes, measured: by wavelengths, the near band's waves, and harmonics.

        Overlaps of so many harmonics take as many angles, about as many shifts, and as many nodes either way; or as
        many of all these as the steepest slope says, where that is more.
        """
        near, harmonics = self.image.bands[0], 2 * self.image.transfers.most + 1
        return (
            CHECKED
            + CHECKED_COLOUR * self._colours
            + CHECKED_WAVE * near.cut * near.reach
            + CHECKED_TURN * harmonics**4
            + self._search_seconds
        )

    @cached_property
    def _search_seconds(self) -> float:
        """What overlaps take of the nodes that a search for enough of them begins with."""
        farthest, nm = self.image.lens.at(self.image.radii_um[1], 0.0), self.job.signals.wavelength_nm
        rule, shifts, angles, colours = first_nodes(farthest, nm, self.job.tolerance)
        return CHECKED_OVERLAP * float(rule**2 * shifts * angles * min(colours, nm.size))

    @property
    def least_seconds(self) -> float:
        """What it takes with its check at the least, as far as that is known before there are any transfers."""
        transfers = SECONDS + EACH_TRANSFER * self._colours * FEWEST_RADII
        each = CHECKED + CHECKED_COLOUR * self._colours + LEAST_SEARCH * self._search_seconds
        return transfers + min(FEWEST, self.job.grid.rows * self.job.grid.cols) * each

    def planned_seconds(self, most: float = math.inf) -> float:
        """Return what it takes with its check at the least, as far as that is known before most transfers are made.

        most : seconds that it may take to find out; infinite where that is too few
        """
        try:
            with self.image.planned.sampler.within(most):
                planned = self.image.planned
                return self.least_seconds + planned.seconds + EACH_KEPT * planned.most_kept_bytes
        except TooLong:
            return math.inf

    @cached_property
    def cost(self) -> Cost:
        """What one image takes; what is too much without its transfers is told without them."""
        closed, grid = self.closed.cost, self.job.grid
        if self.image.held_bytes > MEMORY_LIMIT_BYTES:
            return Cost(seconds=self.planned_seconds(), memory_bytes=closed.memory_bytes + self.image.held_bytes)
        transfers = SECONDS + EACH_TRANSFER * self._colours * self.image.transfers.radii.nodes.size
        parts = self.image.parts
        photosites = sum(part.tiles * part.band.period**2 for part in parts)
        tiles = EACH_FREQUENCY * self.frequencies + EACH_PHOTOSITE * photosites
        lines = EACH_PIECE * sum(len(part.pieces.frame) for part in parts) + EACH_CHORD * len(self.slivers.points)
        return Cost(
            seconds=closed.seconds + transfers + tiles + lines,
            memory_bytes=closed.memory_bytes + 8.0 * grid.rows * grid.cols + self.image.memory_bytes,
        )

    def work(self, images: int) -> Work:
        """Count what is done."""
        return dataclasses.replace(self.closed.work(images), frequencies=images * round(self.frequencies))

    def decisions(self) -> Iterator[Decision]:
        """Yield what is done of the lens, and what distortion makes of edges."""
        near, far = self.image.bands[0], self.image.bands[-1]
        transfers = self.image.transfers
        finest = self.image.parts[0]
        assert finest.counts is not None
        across, down = finest.counts
        yield Decision(
            topic="field",
            decision=f"the perfect lens, and what differs within {far.reach:.3g} pitches, the fine part of it within "
            f"{near.reach:.3g}: patterns of {across} × {down} places in boxes of {finest.band.box} photosites",
            reason=f"transfers at {transfers.radii.nodes.size} distances from the axis, turned and interpolated",
        )
        yield from bent_sides(self.job)
        yield from self.closed.decisions()

    def of(self, job: Job) -> FieldPlan:
        """Return the same lens for other edges."""
        return FieldPlan.of_job(job, self.image.lens)

    def bands(self, channel: Channels, progress: Progress) -> Iterator[F64]:
        """Yield the image band by band."""
        rest = self.image.rendered(channel[:], lambda done: progress(0.8 * done))
        self.slivers.add(channel[:], rest)
        closed = self.closed.bands(channel, lambda done: progress(0.8 + 0.2 * done))
        yield from added([closed, iter((rest,))])

    def images(self, channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
        """Yield the bands of several images in turn."""
        return one_by_one(self, channels, progress)

    def standard_error(self, rows: I64, cols: I64) -> float | None:
        """Return None: no chance."""
        return None


def _perfect(job: Job, lens: Revolves) -> Job:
    return dataclasses.replace(job, split=Split(core=Airy(f_number=lens.f_number), moved_um=(0.0, 0.0), rest=None))
