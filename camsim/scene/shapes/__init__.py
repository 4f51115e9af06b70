"""The kinds of shapes, in µm on the sensor: x to the right, y down, origin on the optical axis."""

from camsim.scene.shapes.group import Group, RepeatOnGrid, RepeatOnRing
from camsim.scene.shapes.path import Path
from camsim.scene.shapes.polygons import Polygon, Rectangle, RegularPolygon, Star
from camsim.scene.shapes.rounds import Disc, Ellipse, Ring, Sector

__all__ = [
    "Disc",
    "Ellipse",
    "Group",
    "Path",
    "Polygon",
    "Rectangle",
    "RegularPolygon",
    "RepeatOnGrid",
    "RepeatOnRing",
    "Ring",
    "Sector",
    "Star",
]
