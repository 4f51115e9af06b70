"""What is in front of the camera, as it falls on the sensor: flat shapes, each with a spectrum."""

from camsim.scene import charts
from camsim.scene.arrange import Arrangement, arrange
from camsim.scene.scene import Scene
from camsim.scene.shapes import Disc, Polygon, Rectangle, Shape

__all__ = ["Arrangement", "Disc", "Polygon", "Rectangle", "Scene", "Shape", "arrange", "charts"]
