"""Where the patches lie: what is seen of each shape of a scene, where the lens puts it, less a margin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from camsim.camera.body import Body
from camsim.camera.capture import Capture
from camsim.core.arrays import F64
from camsim.core.errors import UnsupportedError
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
"""Straight lines are bent in pieces: distortion by 5 % over 12 mm leaves chords a few hundredths of a pixel off."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchArea:
    """An evenly coloured area.

    inside : (roi.rows, roi.cols) which photosites of the rectangle count
    """

    name: str
    reflectance: Spectrum
    roi: Roi
    inside: npt.NDArray[np.bool_]


def margin_pixel(capture: Capture) -> float:
    """Return what is left out along a patch's outline.

    3 px for the development, 4 λN for the blur (in green; behind aberrations the λN of a perfect lens with that MTF50),
    and what lateral colour and coma move.
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
    """Return the patches that a capture shows, in painter's order, and how many shapes show too little to measure.

    A patch is what is seen of one shape of even colour, in one piece and without holes: a chart's frame is none.
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
        # Beyond the window too: a frame is hollow although the window may cut through all of its holes.
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
    """Return an area as the lens bends it, or (``scene_place_um``) as it was before."""
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
    """Return the photosites with their centres in an area, None where they are few."""
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
    """Return the photosites of an image in a polygon: their rectangle, and which of it; None where they are few.

    corners : (n, 2) x and y in pixels
    """
    import shapely

    return _inside(shapely.Polygon(corners), shape)


def _inside(area: Any, shape: tuple[int, int]) -> tuple[Roi, npt.NDArray[np.bool_]] | None:
    """Return photosites with their centres in an area in pixels."""
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
    """Number the patches that have a name in common."""
    names = [patch.name for patch in patches]
    seen: dict[str, int] = {}
    stated = []
    for patch in patches:
        number = seen[patch.name] = seen.get(patch.name, 0) + 1
        name = patch.name if names.count(patch.name) == 1 else f"{patch.name} ({number})"
        stated.append(PatchArea(name=name, reflectance=patch.reflectance, roi=patch.roi, inside=patch.inside))
    return stated
