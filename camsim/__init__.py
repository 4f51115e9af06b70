"""camsim: a spectral camera that runs from a YAML file.

The public names load when they are first used: ``import camsim`` itself is nearly free.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camsim.camera import Camera as Camera
    from camsim.capturing import capture as capture
    from camsim.errors import CamsimError as CamsimError
    from camsim.exposing import Capture as Capture
    from camsim.files import save as save
    from camsim.frame import Frame as Frame
    from camsim.optics import Airy as Airy
    from camsim.optics import AnnularAiry as AnnularAiry
    from camsim.optics import CircularPhotosite as CircularPhotosite
    from camsim.optics import EllipticalGaussian as EllipticalGaussian
    from camsim.optics import FourSpotOlpf as FourSpotOlpf
    from camsim.optics import Gaussian as Gaussian
    from camsim.optics import MeasuredPsf as MeasuredPsf
    from camsim.optics import PolygonPhotosite as PolygonPhotosite
    from camsim.optics import Pupil as Pupil
    from camsim.optics import RadialOtf as RadialOtf
    from camsim.optics import RectangularPhotosite as RectangularPhotosite
    from camsim.optics import RoundedPhotosite as RoundedPhotosite
    from camsim.optics import SquarePhotosite as SquarePhotosite
    from camsim.optics import Wavefront as Wavefront
    from camsim.rendering import Grid as Grid
    from camsim.rendering import Rendering as Rendering
    from camsim.rendering import render as render
    from camsim.scene import Disc as Disc
    from camsim.scene import Polygon as Polygon
    from camsim.scene import Rectangle as Rectangle
    from camsim.scene import Scene as Scene
    from camsim.sensor.adc import Adc as Adc
    from camsim.sensor.cfa import Cfa as Cfa
    from camsim.sensor.conversion_gain import DualGain as DualGain
    from camsim.sensor.exposure import Exposure as Exposure
    from camsim.sensor.falloff import Cos4Falloff as Cos4Falloff
    from camsim.sensor.falloff import RadialFalloff as RadialFalloff
    from camsim.sensor.quantum_efficiency import QuantumEfficiency as QuantumEfficiency
    from camsim.sensor.stage import ElectronicStage as ElectronicStage
    from camsim.sensor.stage import Phase as Phase
    from camsim.sensor.stages.blooming import Blooming as Blooming
    from camsim.sensor.stages.column_noise import ColumnNoise as ColumnNoise
    from camsim.sensor.stages.crosstalk import Crosstalk as Crosstalk
    from camsim.sensor.stages.dark_current import DarkCurrent as DarkCurrent
    from camsim.sensor.stages.defects import Defects as Defects
    from camsim.sensor.stages.dsnu import Dsnu as Dsnu
    from camsim.sensor.stages.flicker_rows import FlickerRows as FlickerRows
    from camsim.sensor.stages.full_well import FullWell as FullWell
    from camsim.sensor.stages.nonlinearity import PolynomialResponse as PolynomialResponse
    from camsim.sensor.stages.nonlinearity import ResponseTable as ResponseTable
    from camsim.sensor.stages.output_noise import OutputNoise as OutputNoise
    from camsim.sensor.stages.prnu import Prnu as Prnu
    from camsim.sensor.stages.read_noise import ReadNoise as ReadNoise
    from camsim.sensor.stages.reset_noise import ResetNoise as ResetNoise
    from camsim.sensor.stages.row_noise import RowNoise as RowNoise
    from camsim.sensor.stages.shot_noise import ShotNoise as ShotNoise
    from camsim.spectra.curve import Curve as Curve
    from camsim.spectra.light import Light as Light
    from camsim.spectra.named import reflectance as reflectance
    from camsim.window import Region as Region

_HOME = {
    "camsim.camera": ("Camera",),
    "camsim.capturing": ("capture",),
    "camsim.errors": ("CamsimError",),
    "camsim.exposing": ("Capture",),
    "camsim.files": ("save",),
    "camsim.frame": ("Frame",),
    "camsim.optics": (
        "Airy",
        "AnnularAiry",
        "CircularPhotosite",
        "EllipticalGaussian",
        "FourSpotOlpf",
        "Gaussian",
        "MeasuredPsf",
        "PolygonPhotosite",
        "Pupil",
        "RadialOtf",
        "RectangularPhotosite",
        "RoundedPhotosite",
        "SquarePhotosite",
        "Wavefront",
    ),
    "camsim.rendering": ("Grid", "Rendering", "render"),
    "camsim.scene": ("Disc", "Polygon", "Rectangle", "Scene"),
    "camsim.sensor.adc": ("Adc",),
    "camsim.sensor.cfa": ("Cfa",),
    "camsim.sensor.exposure": ("Exposure",),
    "camsim.sensor.conversion_gain": ("DualGain",),
    "camsim.sensor.falloff": (
        "Cos4Falloff",
        "RadialFalloff",
    ),
    "camsim.sensor.quantum_efficiency": ("QuantumEfficiency",),
    "camsim.sensor.stage": ("ElectronicStage", "Phase"),
    "camsim.sensor.stages.blooming": ("Blooming",),
    "camsim.sensor.stages.column_noise": ("ColumnNoise",),
    "camsim.sensor.stages.crosstalk": ("Crosstalk",),
    "camsim.sensor.stages.dark_current": ("DarkCurrent",),
    "camsim.sensor.stages.defects": ("Defects",),
    "camsim.sensor.stages.dsnu": ("Dsnu",),
    "camsim.sensor.stages.flicker_rows": ("FlickerRows",),
    "camsim.sensor.stages.full_well": ("FullWell",),
    "camsim.sensor.stages.nonlinearity": (
        "PolynomialResponse",
        "ResponseTable",
    ),
    "camsim.sensor.stages.output_noise": ("OutputNoise",),
    "camsim.sensor.stages.prnu": ("Prnu",),
    "camsim.sensor.stages.read_noise": ("ReadNoise",),
    "camsim.sensor.stages.reset_noise": ("ResetNoise",),
    "camsim.sensor.stages.row_noise": ("RowNoise",),
    "camsim.sensor.stages.shot_noise": ("ShotNoise",),
    "camsim.spectra.curve": ("Curve",),
    "camsim.spectra.light": ("Light",),
    "camsim.spectra.named": ("reflectance",),
    "camsim.window": ("Region",),
}
_MODULE_OF = {name: module for module, names in _HOME.items() for name in names}

__all__ = sorted([*_MODULE_OF, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("camsim-spectral")
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'camsim' has no attribute {name!r}")
    return getattr(importlib.import_module(_MODULE_OF[name]), name)


def __dir__() -> list[str]:
    return __all__
