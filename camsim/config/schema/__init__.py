"""What may stand in a YAML file: names, types, ranges, units and defaults; data only, no behaviour.

Every field says what it means and in which unit: messages, reference and JSON Schema are made of that.
"""

from camsim.config.schema.base import Called, Curve, Fractions, Letter, Table
from camsim.config.schema.scene import (
    AiryLens,
    Background,
    Disc,
    Exposure,
    Light,
    Noise,
    Polygon,
    Rectangle,
    Region,
    Render,
    SceneContent,
    SceneFile,
    Shape,
)
from camsim.config.schema.sensor import (
    BayerCfa,
    Charge,
    FourSpotOlpf,
    MonoCfa,
    QuantumEfficiency,
    Readout,
    SensorFile,
    SensorFrame,
    SquarePhotosite,
)

__all__ = [
    "AiryLens",
    "Background",
    "BayerCfa",
    "Called",
    "Charge",
    "Curve",
    "Disc",
    "Exposure",
    "FourSpotOlpf",
    "Fractions",
    "Letter",
    "Light",
    "MonoCfa",
    "Noise",
    "Polygon",
    "QuantumEfficiency",
    "Readout",
    "Rectangle",
    "Region",
    "Render",
    "SceneContent",
    "SceneFile",
    "SensorFile",
    "SensorFrame",
    "Shape",
    "SquarePhotosite",
    "Table",
]
