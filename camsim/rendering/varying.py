"""Scenes behind a field-varying lens: distorted, then summed over frequencies, part by part of the frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from camsim.core.arrays import F64, I64, U8, distinct
from camsim.core.cached import cached_property
from camsim.errors import InvalidValueError, UnsupportedError
from camsim.optics import OpticalSystem
from camsim.optics.of_pupil import OfPupil
from camsim.optics.placed import PlacedLens, Revolves
from camsim.optics.protocols import KnowsWaves, Rectangular, Varies
from camsim.rendering.auto import FREQUENCIES, Choice, fits
from camsim.rendering.bending import Bending
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.direct.checks import in_channels
from camsim.rendering.engine import Decision, Plan, too_much
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.flat import FlatPlan
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.spectral import Signals, carrying, fuse_by_light
from camsim.rendering.waves.bent_fields import BentSource
from camsim.rendering.waves.field_lens import VaryingImage, VaryingLens
from camsim.rendering.waves.field_transfers import PLANES
from camsim.rendering.waves.image import Source
from camsim.rendering.waves.plan import OF_TRANSFER, WavesPlan, planned, spot_um
from camsim.scene import Scene
from camsim.scene.arrange import Arrangement

FINEST = 1e-8  # tolerance offered behind such lenses; nobody takes a finer one
FEWEST, MOST, OF_IMAGE, SECONDS = 2, 4, 0.1, 0.12  # photosites checked, by the image's seconds; and seconds of each
MIDDLE = 0.01, 0.99  # quantiles of the light between which a wavefront's phase sets the number of nodes
DIGITS, DIGITS_POWER, NODES_OF_WAVE = 0.65, 1.6, 2.0  # rule for the number of wavelengths
OF_CHECK = 0.7  # tolerance of the check over that of the image
PLACES = 5  # along either side of the window, at which the lens's spot is computed


@dataclass(frozen=True, kw_only=True, eq=False)
class VaryingPlan(WavesPlan):
    """A plan for edges that are already distorted and fields that are not yet; the job's system has the axial lens."""

    lens: Varies

    summed: ClassVar = VaryingImage  # type: ignore[assignment]

    def _lens(self, wavelength_nm: F64, tolerance: float) -> VaryingLens:  # type: ignore[override]
        return VaryingLens(
            lens=self.lens,
            system=self.job.system,
            wavelength_nm=wavelength_nm,
            pitch_um=self.job.grid.pitch_um,
            allowed=OF_TRANSFER * tolerance,
            planes_nm=self._planes_nm,
        )

    @cached_property
    def _planes_nm(self) -> tuple[float, float]:
        """Path differences of the tilts at the window's centre; zero for a lens of revolution, whose tilts rotate."""
        low, high = window_um(self.job.grid)
        x, y = (0.5 * (low + high)).tolist()
        middle = self.lens.at(x, y)
        if not isinstance(middle, PlacedLens) or (isinstance(self.lens, Revolves) and self.lens.turns):
            return 0.0, 0.0
        nm = float(np.mean(self.job.signals.wavelength_nm))
        paths = dict(zip(middle.zernike, (middle.coefficients(np.array([nm]))[0] * nm).tolist(), strict=True))
        return paths.get(PLANES[0], 0.0), paths.get(PLANES[1], 0.0)

    def _source(self, layer: Layer | PointLayer, mixture: F64, cut: float, precision: float) -> Source:
        if not self.lens.distorts:
            return super()._source(layer, mixture, cut, precision)
        return BentSource(
            layer=layer,
            mixture=mixture,
            cut=cut,
            precision=precision,
            lens=self.lens,
            pitch_um=self.job.grid.pitch_um,
        )

    @cached_property
    def _lenses(self) -> list[OfPupil]:
        """Lenses at a few places over the window."""
        low, high = window_um(self.job.grid)
        x, y = (distinct(np.linspace(a, b, PLACES)) for a, b in zip(low, high, strict=True))
        each = [self.lens.at(item, other) for item in x.tolist() for other in y.tolist()]
        return [one for one in each if isinstance(one, OfPupil)]

    def fused(self, signals: Signals, tolerance: float) -> tuple[F64, F64]:
        """Return few wavelengths, distributed by the light, and the weights of signals at them."""
        light = np.cumsum(np.abs(signals.density).sum(axis=(0, 1)))
        low, high = np.interp(MIDDLE, light / light[-1], signals.wavelength_nm).tolist()
        waves = (one.waves_turned(low, high) for one in self._lenses if isinstance(one, KnowsWaves))
        digits: float = max(-math.log10(tolerance), 1.0) ** DIGITS_POWER
        return fuse_by_light(signals, math.ceil(DIGITS * digits + NODES_OF_WAVE * max(waves, default=0.0)) + 2)

    def _spot_um(self, wavelength_nm: float) -> float:
        return max((spot_um(one, wavelength_nm) for one in self._lenses), default=0.0)

    def decisions(self) -> Iterator[Decision]:
        """Yield the decisions that are reported to the user."""
        yield Decision(
            topic="field",
            decision="transfers of a few places in each part of the frame",
            reason="what lies between is interpolated",
        )
        if self.job.bending is not None:
            yield Decision(
                topic="distortion",
                decision=f"{len(self.job.edges)} straight sides",
                reason="edges are mapped before they are blurred, and cut until no photosite can tell them from curves",
            )
        yield from super().decisions()


def choose_varying(
    scene: Scene,
    edges: Scene,
    arrangement: Arrangement,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    share: float,
    tolerance: float,
    method: str,
) -> Choice:
    """Plan a rendering behind a lens with ``Varies``; arguments as in ``render_channels``.

    edges : the scene with frames in place of pictures;  share: part of the tolerance for edges
    """
    lens = system.lens
    assert isinstance(lens, Varies)
    if method not in ("auto", "fourier"):
        raise UnsupportedError(f"{method} renders one pattern for all of the frame; use fourier or auto", key="method")
    if tolerance < FINEST:
        raise InvalidValueError(
            f"{tolerance:g} is finer than a lens that changes over the frame is rendered to: {FINEST:g}",
            key="tolerance",
        )
    seen_nm = wavelength_nm[carrying(response)]
    low, high = window_um(grid)
    corners_um = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    if wrong := lens.lacks(seen_nm, corners_um):
        raise UnsupportedError(f"the lens {wrong}", key="lens")
    bending = _bending(lens, system, grid, seen_nm, share * tolerance) if lens.distorts else None
    if bending is not None:
        sides = bending.sides(arrangement.start_um, arrangement.end_um)
        arrangement = dataclasses.replace(
            arrangement,
            start_um=sides.start,
            end_um=sides.end,
            left=arrangement.left[sides.owner],
            right=arrangement.right[sides.owner],
        )
    job = Job.of(
        edges,
        arrangement,
        dataclasses.replace(system, lens=lens.at(0.0, 0.0)),
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=tolerance,
        bending=bending,
    )
    fields = None
    if edges is not scene:
        fields = FieldJob.of(
            scene,
            system,
            grid,
            response=response,
            wavelength_nm=wavelength_nm,
            scale=job.signals.scale,
            tolerance=tolerance if share == 1.0 else (1.0 - share) * tolerance,
        )
        fields = fields if fields.layers else None
    if not len(job.edges) and fields is None:
        flat = FlatPlan(job=job)
        return Choice(method="fourier", why="there is nothing to render", plan=flat, checker=FieldCheck(plan=flat))
    plan = planned(VaryingPlan, job=job, fields=fields, lens=lens, settings=FREQUENCIES)
    if not fits(plan):
        raise too_much("fourier", plan.cost.memory_bytes)
    why = "asked for" if method == "fourier" else "the lens changes over the frame"
    return Choice(method="fourier", why=why, plan=plan, checker=FieldCheck(plan=plan))


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldCheck:
    """Recomputes photosites, each with the lens at its place and with separate tables and levels.

    plan : its sources are reused, but nothing derived from the lens
    """

    plan: VaryingPlan | FlatPlan

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of photosites near corners of outlines, at the frame's corners, and at random."""
        job = self.plan.job
        grid = job.grid
        draw = np.random.default_rng([grid.rows, grid.cols, len(job.edges)])
        first = np.array(grid.first_centre)
        size = np.array([grid.cols, grid.rows])
        near = np.rint(job.edges.start - first).astype(np.int64)
        near = near[((near >= 0) & (near < size)).all(axis=1)]
        places = [np.array([0, 0]), size - 1, *draw.integers(0, size, (MOST, 2))]
        if len(near):
            farthest = near[np.argmax(np.hypot(*(near + first).T))]
            places = [farthest, near[draw.integers(len(near))], *places]
        col, row = np.unique(np.array(places[: self._count]), axis=0).T.astype(np.int64)
        return row, col

    def seconds(self, plan: Plan) -> float:
        """Return the expected seconds of the check."""
        return 0.0 if isinstance(self.plan, FlatPlan) else self._count * SECONDS

    @property
    def _count(self) -> int:
        """Return how many photosites are checked."""
        return max(FEWEST, min(MOST, int(OF_IMAGE * self.plan.cost.seconds / SECONDS)))

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Recompute photosites, each in its channel of ``sets`` (..., photosites)."""
        plan, values = self.plan, self.plan.job.base[sets]
        if isinstance(plan, FlatPlan):
            return values
        fields = plan.fields and dataclasses.replace(plan.fields, tolerance=OF_CHECK * plan.fields.tolerance)
        job = plan.job.to(OF_CHECK * plan.job.tolerance)
        if plan.image is not None:
            sources = [
                (source, weights, dataclasses.replace(lens, allowed=OF_CHECK * lens.allowed))
                for source, weights, lens in plan.image.sources
            ]
            image = dataclasses.replace(plan, job=job, fields=fields).on_levels(sources)
            assert isinstance(image, VaryingImage)
            values += in_channels(image.at(job.grid.first_centre, rows, cols), sets)
        return values


def _bending(lens: Varies, system: OpticalSystem, grid: Grid, seen_nm: F64, tolerance: float) -> Bending:
    photosite, peak_per_um = system.photosite, math.inf
    if isinstance(photosite, Rectangular) and min(photosite.sides_um) > 0.0:
        # The line spread of a rectangle is highest along its diagonal.
        peak_per_um = math.hypot(*photosite.sides_um) / math.prod(photosite.sides_um)
    return Bending(
        lens=lens,
        grid=grid,
        blur_um=system.blur_um(float(seen_nm.min())),
        peak_per_um=peak_per_um,
        allowed=ErrorBudget(tolerance).allowed("bent edges"),
    )


def window_um(grid: Grid) -> tuple[F64, F64]:
    """Return the centres of the window's first and last photosite, µm."""
    first = np.array(grid.first_centre)
    return grid.pitch_um * first, grid.pitch_um * (first + np.array([grid.cols - 1, grid.rows - 1]))
