"""The MTF of charts other than edges: a Siemens star by its rings, any texture by the scene's own truth."""

from camsim.measure.target.result import TargetMtf, TargetReport
from camsim.measure.target.star import measure_star
from camsim.measure.target.texture import measure_texture

__all__ = ["TargetMtf", "TargetReport", "measure_star", "measure_texture"]
