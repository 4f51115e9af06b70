"""The chart as it was photographed, with the right half of every patch in its reference colour."""

from __future__ import annotations

import numpy as np

from camsim.arrays import U8
from camsim.exposing import Capture
from camsim.measure.colour.areas import patch_areas
from camsim.measure.colour.measuring import developed_light, linear_light
from camsim.measure.colour.reference import reference_xyz
from camsim.measure.colour.result import ColourReport
from camsim.measure.demosaic.develop import developed
from camsim.measure.demosaic.subject import CHANNELS
from camsim.measure.picture import Picture
from camsim.measure.straight import straightened
from camsim.sensor.colour_matrix import XYZ_D50, fit_for_development


def halves(picture: Picture, capture: Capture, report: ColourReport) -> U8:
    """Return (rows, cols, 3) sRGB; where a patch's halves look alike, its colour is right."""
    camera = capture.camera
    order = [camera.cfa.channels.index(letter) for letter in CHANNELS]
    to_xyz = fit_for_development(camera.colour_response(capture.light, capture.colour_matrix)).forward[:, order]
    shown = developed(developed_light(linear_light(straightened(picture, capture), capture)), to_xyz)
    measured = {patch.name for patch in report.patches}
    areas = [area for area in patch_areas(capture)[0] if area.name in measured]
    reference = reference_xyz(capture, [area.reflectance for area in areas])
    colours = developed((reference / XYZ_D50)[None].astype(np.float32), np.diag(XYZ_D50))[0]
    for area, colour in zip(areas, colours, strict=True):
        right = area.inside.copy()
        right[:, : right.shape[1] // 2] = False
        roi = area.roi
        shown[roi.row : roi.row + roi.rows, roi.col : roi.col + roi.cols][right] = colour
    codes: U8 = np.rint(255.0 * shown).astype(np.uint8)
    return codes
