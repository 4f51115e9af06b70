"""Optical stages between the scene and the silicon: lens, low-pass filter, photosite; each has an ``otf``."""

from camsim.optics.airy import Airy
from camsim.optics.annular import AnnularAiry
from camsim.optics.field_lens import FieldLens
from camsim.optics.gaussian import EllipticalGaussian, Gaussian
from camsim.optics.measured import MeasuredOtf, MeasuredPsf
from camsim.optics.olpf import FourSpotOlpf, TwoSpotOlpf
from camsim.optics.photosite import (
    CircularPhotosite,
    PolygonPhotosite,
    RectangularPhotosite,
    RoundedPhotosite,
    SquarePhotosite,
)
from camsim.optics.protocols import Lens, LowPass, OpticalStage, PhotositeShape, RoundLens
from camsim.optics.pupil import Pupil
from camsim.optics.radial import RadialOtf
from camsim.optics.system import OpticalSystem
from camsim.optics.wavefront import Wavefront

__all__ = [
    "Airy",
    "AnnularAiry",
    "CircularPhotosite",
    "EllipticalGaussian",
    "FieldLens",
    "FourSpotOlpf",
    "Gaussian",
    "Lens",
    "LowPass",
    "MeasuredOtf",
    "MeasuredPsf",
    "OpticalStage",
    "OpticalSystem",
    "PhotositeShape",
    "PolygonPhotosite",
    "Pupil",
    "RadialOtf",
    "RectangularPhotosite",
    "RoundLens",
    "RoundedPhotosite",
    "SquarePhotosite",
    "TwoSpotOlpf",
    "Wavefront",
]
