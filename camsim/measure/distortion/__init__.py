"""Distortion and lateral colour: measured positions of a chart's marks against those in the scene."""

from camsim.measure.distortion.measuring import measure_distortion
from camsim.measure.distortion.result import (
    ChannelDistortion,
    Displacement,
    DisplacementError,
    DistortionReport,
    MarkPlace,
)
from camsim.measure.distortion.strangers import GridReport, measure_grid

__all__ = [
    "ChannelDistortion",
    "Displacement",
    "DisplacementError",
    "DistortionReport",
    "GridReport",
    "MarkPlace",
    "measure_distortion",
    "measure_grid",
]
