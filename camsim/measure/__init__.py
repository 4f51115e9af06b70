"""Measurements on files or Frames: MTF, noise, colour and more, with an optional theory for comparison."""

from camsim.measure.field import FieldPlace
from camsim.measure.full_frame import FullFrame
from camsim.measure.geometry import EdgeLine, Roi
from camsim.measure.measuring import measure_mtf
from camsim.measure.mtf import TheoreticalOtf, measure_edge
from camsim.measure.picture import Picture, Plane
from camsim.measure.reading import picture_of_frame, read_picture
from camsim.measure.result import EdgeMtf, Figures, MtfReport, Theory
from camsim.measure.series import MtfSeries, mtf_series
from camsim.measure.theory import CameraOtf

__all__ = [
    "CameraOtf",
    "EdgeLine",
    "EdgeMtf",
    "FieldPlace",
    "Figures",
    "FullFrame",
    "MtfReport",
    "MtfSeries",
    "Picture",
    "Plane",
    "Roi",
    "TheoreticalOtf",
    "Theory",
    "measure_edge",
    "measure_mtf",
    "mtf_series",
    "picture_of_frame",
    "read_picture",
]
