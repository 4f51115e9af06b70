"""Charts that cameras are tested with: functions that return shapes, each a line of a scene file.

A chart is a function in a file beside this one, imported here; its keys in files are its parameters.
"""

from camsim.scene.charts.bars import bars
from camsim.scene.charts.chart import KNOWN, Chart, meanings, parameters
from camsim.scene.charts.colorchecker import colorchecker
from camsim.scene.charts.dead_leaves import dead_leaves
from camsim.scene.charts.e_sfr import e_sfr
from camsim.scene.charts.grids import checkerboard, dot_grid, slanted_edges
from camsim.scene.charts.lens_grid import lens_grid
from camsim.scene.charts.points import points
from camsim.scene.charts.qr import qr
from camsim.scene.charts.random_scene import random
from camsim.scene.charts.siemens_star import siemens_star
from camsim.scene.charts.step_wedge import step_wedge
from camsim.scene.charts.usaf_1951 import usaf_1951
from camsim.scene.charts.zone_plate import zone_plate

__all__ = [
    "KNOWN",
    "Chart",
    "bars",
    "checkerboard",
    "colorchecker",
    "dead_leaves",
    "dot_grid",
    "e_sfr",
    "lens_grid",
    "meanings",
    "parameters",
    "points",
    "qr",
    "random",
    "siemens_star",
    "slanted_edges",
    "step_wedge",
    "usaf_1951",
    "zone_plate",
]
