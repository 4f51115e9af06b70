"""Colour of the patches of a chart: what the file shows beside what the eye would see."""

from camsim.measure.colour.measuring import measure_colour
from camsim.measure.colour.result import ColourReport, PatchColour, WhiteBalance

__all__ = ["ColourReport", "PatchColour", "WhiteBalance", "measure_colour"]
