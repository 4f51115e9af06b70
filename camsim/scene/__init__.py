"""Scenes in sensor coordinates: flat shapes, each with a spectrum."""

from camsim.scene import charts
from camsim.scene.arrange import Arrangement, arrange
from camsim.scene.charts import Chart
from camsim.scene.gradients import LinearGradient, RadialGradient, SineGrating, SineStar, SineZonePlate
from camsim.scene.picture import Picture
from camsim.scene.point_source import PointSource
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
from camsim.scene.svg import Svg, read_svg

__all__ = [
    "Arrangement",
    "Chart",
    "Disc",
    "Ellipse",
    "Group",
    "HalfPlane",
    "Line",
    "LinearGradient",
    "Path",
    "Picture",
    "PointSource",
    "Polygon",
    "Primitive",
    "RadialGradient",
    "Rectangle",
    "RegularPolygon",
    "RepeatOnGrid",
    "RepeatOnRing",
    "Ring",
    "Scene",
    "Sector",
    "Shape",
    "SineGrating",
    "SineStar",
    "SineZonePlate",
    "Star",
    "Svg",
    "Text",
    "arrange",
    "charts",
    "flattened",
    "read_svg",
]
