"""A picture of the chart with the right half of every patch in its reference colour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camsim.camera.capture import Capture
from camsim.core.arrays import F32, F64, U8
from camsim.measure.colour.areas import PatchArea, patch_areas
from camsim.measure.colour.chart import Corner
from camsim.measure.colour.measuring import developed_chart, developed_light, linear_light
from camsim.measure.colour.reference import reference_xyz
from camsim.measure.colour.result import ColourReport
from camsim.measure.demosaic.develop import developed
from camsim.measure.demosaic.subject import CHANNELS
from camsim.measure.picture import Picture
from camsim.measure.straight import straightened
from camsim.sensor.colour_matrix import XYZ_D50, fit_for_development
from camsim.spectra.light import Light


def halves(picture: Picture, capture: Capture, report: ColourReport) -> U8:
    """Return (rows, cols, 3) sRGB, in which a patch of the right colour has two equal halves."""
    camera = capture.camera
    order = [camera.cfa.channels.index(letter) for letter in CHANNELS]
    to_xyz = fit_for_development(camera.colour_response(capture.light, capture.colour_matrix)).forward[:, order]
    displayed = developed(developed_light(linear_light(straightened(picture, capture), capture)), to_xyz)
    measured = {patch.name for patch in report.patches}
    areas = [area for area in patch_areas(capture)[0] if area.name in measured]
    return _with_references(
        displayed, areas, (0, 0), reference_xyz(capture.light, [area.reflectance for area in areas])
    )


def halves_of_chart(picture: Picture, light: Light, *, corners: Sequence[Corner] | None, chart: str) -> U8:
    """Return (rows, cols, 3) sRGB of the part of any picture that contains the chart, made like ``halves``."""
    _, seen, one = developed_chart(picture, light, corners=corners, chart=chart)
    displayed = developed(developed_light((seen.light / one.neutral).astype(np.float32)), one.to_xyz)
    reference = reference_xyz(light, [area.reflectance for area in seen.areas])
    return _with_references(displayed, seen.areas, seen.window[:2], reference)


def _with_references(displayed: F32, areas: Sequence[PatchArea], corner: tuple[int, int], reference: F64) -> U8:
    """Return a developed picture whose patches' right halves have the colours (n, 3), XYZ under D50."""
    colours = developed((reference / XYZ_D50)[None].astype(np.float32), np.diag(XYZ_D50))[0]
    for area, colour in zip(areas, colours, strict=True):
        right = area.inside.copy()
        right[:, : right.shape[1] // 2] = False
        row, col = area.roi.row - corner[0], area.roi.col - corner[1]
        displayed[row : row + area.roi.rows, col : col + area.roi.cols][right] = colour
    codes: U8 = np.rint(255.0 * displayed).astype(np.uint8)
    return codes
