"""What is in front of the camera, as it falls on the sensor: flat shapes, each with a spectrum."""

from camsim.scene.arrange import Arrangement, arrange
from camsim.scene.picture import Picture
from camsim.scene.scene import Scene
from camsim.scene.shapes import Disc, Polygon, Rectangle, Shape

__all__ = ["Arrangement", "Disc", "Picture", "Polygon", "Rectangle", "Scene", "Shape", "arrange"]
