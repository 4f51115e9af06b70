"""Areas of the patches: the visible part of each shape of a scene, distorted by the lens, minus a margin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.camera.body import Body
from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.geometry import Roi
from camsim.measure.lens_places import fallen_um, middles_um, scene_place_um, system_at
from camsim.optics import OpticalSystem
from camsim.optics.protocols import Varies
from camsim.scene.outlines import Outlines, area_of
from camsim.scene.primitives import Primitive
from camsim.scene.raster import Field
from camsim.scene.side_limits import SideLimits
from camsim.spectra.curve import Spectrum

_MOST_SHAPES = 2000
_LEAST_PHOTOSITES = 64
_MARGIN_PX = 3.0
_BLURS = 4.0
_GREEN_NM = 550.0
_AIRY_50 = 0.404
"""MTF50 of a perfect lens in 1/λN."""

_HALF = 0.5**0.5
_PIECE_PX = 32.0
"""Length of pieces of distorted lines: at 5 % distortion over 12 mm, chords are off by a few hundredths of a pixel."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchArea:
    """An area of uniform colour.

    inside : (roi.rows, roi.cols) mask of the photosites used within the rectangle
    """

    name: str
    reflectance: Spectrum
    roi: Roi
    inside: npt.NDArray[np.bool_]


def margin_pixel(capture: Capture) -> float:
    """Return the width of the margin that is left out along a patch's outline.

    3 px for demosaicing, 4 λN for the blur (in green; for aberrated lenses the λN of a perfect lens with that MTF50),
    plus shifts by lateral colour and coma.
    """
    camera, places = capture.camera, _places_um(capture)
    blur_um = max(_blur_um(system_at(camera, *place)) for place in places.tolist())
    blur_um = max(blur_um, 1e-3 * _GREEN_NM * camera.working_f_number)
    moved_um = max(float(np.hypot(*each.T).max()) for each in middles_um(capture, places, (0.0, 1.0)).values())
    return _MARGIN_PX + (_BLURS * blur_um + moved_um) / camera.pitch_um


def _places_um(capture: Capture) -> F64:
    """Return (5, 2): the corners and the middle of the picture."""
    left, top, right, bottom = _window_um(capture)
    return np.array(
        [(left, top), (left, bottom), (right, top), (right, bottom), ((left + right) / 2, (top + bottom) / 2)]
    )


def _blur_um(system: OpticalSystem) -> float:
    """Return the λN of the perfect lens with the MTF50 of a lens in its worst direction."""
    f = np.geomspace(1e-3, 1.0, 200) * system.cutoff_per_um(_GREEN_NM)
    ways = (1.0, 0.0), (0.0, 1.0), (_HALF, _HALF), (_HALF, -_HALF)
    low = np.min([system.point_otf_size(f, way, _GREEN_NM) for way in ways], axis=0) < 0.5
    return _AIRY_50 / float(f[np.argmax(low)] if low.any() else f[-1])


def patch_areas(capture: Capture) -> tuple[list[PatchArea], int]:
    """Return the patches of a capture, in painter's order, and the number of shapes too small to measure.

    A patch is the visible part of one shape of uniform colour, connected and without holes: not a chart's frame.
    """
    import shapely

    painted = [
        (one, not isinstance(shape, Field))
        for shape in capture.scene.shapes
        for one in (shape.frame(0.0) if isinstance(shape, Field) else shape).primitives()
    ]
    if len(painted) > _MOST_SHAPES:
        raise UnsupportedError(
            f"the scene has {len(painted)} shapes; patches are looked for among {_MOST_SHAPES} at most",
            stage=capture.scene_name,
        )
    margin_um = margin_pixel(capture) * capture.camera.pitch_um
    window = _moved(shapely.box(*_window_um(capture)), capture, scene_place_um)
    found: list[PatchArea] = []
    covered, small = shapely.Polygon(), 0
    for one, even in reversed(painted):
        area = _area(one)
        seen = shapely.difference(area, covered)
        covered = shapely.union(covered, area)
        inside = shapely.intersection(seen, window)
        if not even or inside.is_empty:
            continue
        # Beyond the window too: a frame counts as hollow even if the window cuts through all of its holes.
        pieces = [part for part in shapely.get_parts(seen) if part.geom_type == "Polygon" and part.area > 0.0]
        if len(pieces) == 1 and not pieces[0].interiors:
            patch = _photosites(shapely.buffer(_moved(inside, capture, fallen_um), -margin_um), one, capture)
            if patch is not None:
                found.append(patch)
                continue
        small += 1
    found.reverse()
    return _distinguishable(found), small


def _window_um(capture: Capture) -> tuple[float, float, float, float]:
    """Return left, top, right and bottom of the picture."""
    grid = capture.grid
    left, top = ((first - 0.5) * grid.pitch_um for first in grid.first_centre)
    return left, top, left + grid.cols * grid.pitch_um, top + grid.rows * grid.pitch_um


def _moved(area: Any, capture: Capture, places: Callable[[Body, F64], F64]) -> Any:
    """Return an area distorted by the lens, or (``scene_place_um``) undistorted."""
    import shapely

    camera = capture.camera
    if not isinstance(camera.lens, Varies) or not camera.lens.distorts:
        return area
    return shapely.transform(
        shapely.segmentize(area, _PIECE_PX * camera.pitch_um), lambda points: places(camera, points)
    )


def _area(one: Primitive) -> Any:
    return area_of(one, Outlines.of([one]).rings(SideLimits())[0])


def _photosites(area: Any, one: Primitive, capture: Capture) -> PatchArea | None:
    """Return the photosites with centres in an area; None if there are too few."""
    import shapely

    if area.is_empty:
        return None
    grid = capture.grid
    x0, y0 = grid.first_centre
    found = _inside(
        shapely.transform(area, lambda places: places / grid.pitch_um - (x0 - 0.5, y0 - 0.5)), (grid.rows, grid.cols)
    )
    if found is None:
        return None
    colour = one.reflectance
    name = getattr(colour, "name", "") or (f"{colour:g}" if isinstance(colour, float | int) else "patch")
    return PatchArea(name=name, reflectance=colour, roi=found[0], inside=found[1])


def photosites_in(corners: F64, shape: tuple[int, int]) -> tuple[Roi, npt.NDArray[np.bool_]] | None:
    """Return the photosites of an image in a polygon: bounding rectangle and mask; None if there are too few.

    corners : (n, 2) x and y in pixels
    """
    import shapely

    return _inside(shapely.Polygon(corners), shape)


def _inside(area: Any, shape: tuple[int, int]) -> tuple[Roi, npt.NDArray[np.bool_]] | None:
    """Return bounding rectangle and mask of photosites with centres in an area in pixels."""
    import shapely

    low_x, low_y, high_x, high_y = area.bounds
    cols = np.arange(max(0, int(np.ceil(low_x - 0.5))), min(shape[1], int(np.floor(high_x - 0.5)) + 1))
    rows = np.arange(max(0, int(np.ceil(low_y - 0.5))), min(shape[0], int(np.floor(high_y - 0.5)) + 1))
    if not rows.size or not cols.size:
        return None
    x, y = np.meshgrid(cols + 0.5, rows + 0.5)
    inside = shapely.contains_xy(area, x, y)
    if np.count_nonzero(inside) < _LEAST_PHOTOSITES:
        return None
    return Roi(int(rows[0]), int(cols[0]), int(rows.size), int(cols.size)), inside


def _distinguishable(patches: list[PatchArea]) -> list[PatchArea]:
    """Number the patches that share a name."""
    names = [patch.name for patch in patches]
    seen: dict[str, int] = {}
    stated = []
    for patch in patches:
        number = seen[patch.name] = seen.get(patch.name, 0) + 1
        name = patch.name if names.count(patch.name) == 1 else f"{patch.name} ({number})"
        stated.append(PatchArea(name=name, reflectance=patch.reflectance, roi=patch.roi, inside=patch.inside))
    return stated
