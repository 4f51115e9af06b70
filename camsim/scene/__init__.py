"""What is in front of the camera, as it falls on the sensor: flat shapes, each with a spectrum."""

from camsim.scene import charts
from camsim.scene.arrange import Arrangement, arrange
from camsim.scene.charts import Chart
from camsim.scene.primitives import Primitive, Shape, flattened
from camsim.scene.scene import Scene
from camsim.scene.shapes import (
    Disc,
    Ellipse,
    Group,
    HalfPlane,
    Line,
    Path,
    Polygon,
    Rectangle,
    RegularPolygon,
    RepeatOnGrid,
    RepeatOnRing,
    Ring,
    Sector,
    Star,
    Text,
)
from camsim.scene.svg import Drawing, read_svg

__all__ = [
    "Arrangement",
    "Chart",
    "Disc",
    "Drawing",
    "Ellipse",
    "Group",
    "HalfPlane",
    "Line",
    "Path",
    "Polygon",
    "Primitive",
    "Rectangle",
    "RegularPolygon",
    "RepeatOnGrid",
    "RepeatOnRing",
    "Ring",
    "Scene",
    "Sector",
    "Shape",
    "Star",
    "Text",
    "arrange",
    "charts",
    "flattened",
    "read_svg",
]
