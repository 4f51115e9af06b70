"""Charts other than edges: the MTF of a Siemens star or any texture, the moiré of a zone plate."""

from camsim.measure.target.moire import Ghost, MoireReport, measure_moire, measure_plate
from camsim.measure.target.result import TargetMtf, TargetReport
from camsim.measure.target.star import measure_star
from camsim.measure.target.texture import measure_texture

__all__ = [
    "Ghost",
    "MoireReport",
    "TargetMtf",
    "TargetReport",
    "measure_moire",
    "measure_plate",
    "measure_star",
    "measure_texture",
]
