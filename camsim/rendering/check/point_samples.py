"""What the check sees of point sources: those that its own painter's rule leaves to be seen, as points of light."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import F64
from camsim.kept import cached_property
from camsim.rendering.check.scene_samples import Seen, Zone
from camsim.rendering.check.whether_covered import hidden
from camsim.scene import PointSource, Scene, flattened
from camsim.scene.raster import Interpolation, Raster
from camsim.spectra.curve import Spectrum


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


def seen_points(scene: Scene) -> list[PointSource]:
    """Return the points of a scene that nothing covers that is painted later."""
    points = [(number, shape) for number, shape in enumerate(scene.shapes) if isinstance(shape, PointSource)]
    of_each = [flattened([shape]) for shape in scene.framed(0.5).shapes] if points else []
    begins = np.concatenate([[0], np.cumsum([len(own) for own in of_each], dtype=np.int64)])
    at = np.array([complex(*point.centre_um) for _, point in points], np.complex128)
    after = begins[np.array([number for number, _ in points], np.int64)]
    unseen = hidden(at, after, [one for own in of_each for one in own])
    return [point for (_, point), never in zip(points, unseen.tolist(), strict=True) if not never]
