"""Colour of the patches of a chart: measured and reference colours, their differences, and calibration."""

from camsim.measure.colour.calibrating import ColourCalibration, calibrate_colour
from camsim.measure.colour.measuring import measure_chart, measure_colour
from camsim.measure.colour.result import ColourReport, PatchColour, WhiteBalance

__all__ = [
    "ColourCalibration",
    "ColourReport",
    "PatchColour",
    "WhiteBalance",
    "calibrate_colour",
    "measure_chart",
    "measure_colour",
]
