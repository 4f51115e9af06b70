"""What stands between the scene and the silicon: lens, low-pass filter, photosite; each stage has an ``otf``."""

from camsim.optics.airy import Airy
from camsim.optics.gaussian import Gaussian
from camsim.optics.olpf import FourSpotOlpf
from camsim.optics.photosite import SquarePhotosite
from camsim.optics.system import OpticalStage, OpticalSystem

__all__ = ["Airy", "FourSpotOlpf", "Gaussian", "OpticalStage", "OpticalSystem", "SquarePhotosite"]
