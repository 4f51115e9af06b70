"""The kinds of shapes, in µm on the sensor: x to the right, y down, origin on the optical axis."""

from camsim.scene.shapes.group import Group, RepeatOnGrid, RepeatOnRing
from camsim.scene.shapes.half_plane import HalfPlane
from camsim.scene.shapes.line import Line
from camsim.scene.shapes.path import Path
from camsim.scene.shapes.polygons import Polygon, Rectangle, RegularPolygon, Star
from camsim.scene.shapes.rounds import Disc, Ellipse, Ring, Sector
from camsim.scene.shapes.text import Text

__all__ = [
    "Disc",
    "Ellipse",
    "Group",
    "HalfPlane",
    "Line",
    "Path",
    "Polygon",
    "Rectangle",
    "RegularPolygon",
    "RepeatOnGrid",
    "RepeatOnRing",
    "Ring",
    "Sector",
    "Star",
    "Text",
]
