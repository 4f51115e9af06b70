"""What the check sees of point sources: those that its own painter's rule leaves to be seen, as points of light."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.rendering.check.scene_samples import Seen, Zone
from camsim.rendering.check.scenery import pieces_of
from camsim.scene import PointSource, Rectangle, Scene
from camsim.scene.raster import Interpolation, Raster
from camsim.spectra.curve import Curve, Spectrum

SPOT = 1e-4  # pitches: a square that stands for a point where it is asked whether it is seen


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Nothing(Raster):
    """One cell of a pitch with nothing in it."""

    planes: F64
    spectra: tuple[Spectrum, ...]
    width_um: float
    centre_um: tuple[float, float] = (0.0, 0.0)
    rotate_deg: float = 0.0
    interpolation: Interpolation = "squares"


@dataclass(frozen=True, kw_only=True, eq=False)
class SeenPoints(Seen):
    """Points ``at`` (n, 2), pitches, with ``light`` (planes, n), square pitches of each plane's spectrum."""

    at: F64
    light: F64

    @classmethod
    def of(cls, points: Sequence[PointSource], colours: Sequence[Spectrum], pitch_um: float) -> SeenPoints:
        """Place points, a plane for each of the colours."""
        mine = [[point.reflectance == colour for point in points] for colour in colours]
        light = np.where(mine, [point.photosites or 0.0 for point in points], 0.0)
        nothing = _Nothing(planes=np.zeros((len(colours), 1, 1)), spectra=tuple(colours), width_um=pitch_um)
        at = np.array([point.centre_um for point in points], float).reshape(-1, 2) / pitch_um
        return cls(
            picture=nothing, less=np.zeros(len(colours)), ones=False, outline=None, pitch_um=pitch_um, order=1,
            at=at, light=light,
        )  # fmt: skip

    @property
    def whole(self) -> np.ndarray:
        """There are no patches."""
        return np.zeros((1, 1), bool)

    @cached_property
    def loud(self) -> float:
        """Light whose rings are in step, square pitches: of the brightest, and of the others what adds up by chance."""
        each = self.light.sum(axis=0)
        near = scipy.spatial.cKDTree(self.at).query_ball_point(self.at, 1.0)
        return float(max(np.hypot(each[mine].sum(), np.linalg.norm(each)) for mine in near))

    def lit_near(self, point: F64, zones: Sequence[Zone], *, beyond: bool = True) -> Iterator[tuple[F64, F64]]:
        """Yield all of them."""
        yield self.at, np.ascontiguousarray(self.light)

    def points_near(self, zones: Sequence[Zone]) -> F64:
        """Return (zones + 1,) how many there are, as if all were near."""
        counts = np.zeros(len(zones) + 1)
        counts[0] = len(self.at)
        return counts

    def farthest(self, points: F64) -> float:
        """Return the largest distance of a photosite from a point."""
        return float(np.hypot(*(points[:, None] - self.at[None]).transpose(2, 0, 1)).max())


def seen_points(scene: Scene, pitch_um: float) -> list[PointSource]:
    """Return the points of a scene that nothing covers: a small square in the place of each is to be seen."""
    found: list[PointSource] = []
    numbers = [number for number, shape in enumerate(scene.shapes) if isinstance(shape, PointSource)]
    own, beyond = (Curve((400.0, 700.0), ends, name="points", outside="hold") for ends in ((0.25, 0.75), (0.75, 0.25)))
    for _, together in itertools.groupby(enumerate(numbers), lambda one: one[1] - one[0]):
        mine = [number for _, number in together]
        points = [shape for shape in scene.shapes[mine[0] : mine[-1] + 1] if isinstance(shape, PointSource)]
        side_um = SPOT * pitch_um
        spots = [
            Rectangle(width_um=side_um, height_um=side_um, centre_um=point.centre_um, reflectance=own)
            for point in points
        ]
        covered = Scene(background=beyond, shapes=[*spots, *scene.shapes[mine[-1] + 1 :]]).framed(0.5)
        pieces, spectra = pieces_of(covered, pitch_um)
        if own not in spectra:
            continue
        which = spectra.index(own)
        about = np.flatnonzero((pieces.left == which) | (pieces.right == which))
        if not about.size:
            continue
        o = pieces.outlines
        tree = scipy.spatial.cKDTree(np.stack([o.x[about], o.y[about]], axis=1))
        at = np.array([point.centre_um for point in points], float) / pitch_um
        apart, _ = tree.query(at)
        found += [point for point, gap in zip(points, np.asarray(apart).tolist(), strict=True) if gap < 2.0 * SPOT]
    return found
