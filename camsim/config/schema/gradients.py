"""scene/1, gradients and sinusoids among its shapes."""

from typing import Literal

from pydantic import Field

from camsim.config.schema.base import Point, Reflectance, Table

_LOW = "reflectance where it is darkest; names: camsim list reflectances"
_HIGH = "reflectance where it is brightest"


class LinearGradient(Table):
    """A rectangle whose reflectance changes evenly from one side to the other."""

    kind: Literal["linear-gradient"] = Field(description="which shape")
    width: float = Field(gt=0, description="side along which it changes, from left to right before it is turned")
    height: float = Field(gt=0, description="side along y before it is turned, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees")
    low: Reflectance = Field(default=0.0, description="reflectance at its left side; names: camsim list reflectances")
    high: Reflectance = Field(default=1.0, description="reflectance at its right side")


class RadialGradient(Table):
    """A disc whose reflectance changes from centre to rim with the square of the distance."""

    kind: Literal["radial-gradient"] = Field(description="which shape")
    radius: float = Field(gt=0, description="in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    low: Reflectance = Field(default=0.0, description="reflectance at its rim; names: camsim list reflectances")
    high: Reflectance = Field(default=1.0, description="reflectance in its centre")


class SineGrating(Table):
    """A rectangle of sinusoidal waves along its width."""

    kind: Literal["sine-grating"] = Field(description="which shape")
    width: float = Field(gt=0, description="side along which the waves run before it is turned, in the scene's unit")
    height: float = Field(gt=0, description="the other side, in the scene's unit")
    period: float = Field(gt=0, description="of a wave, in the scene's unit")
    phase_deg: float = Field(default=0.0, description="of the wave in its centre, 0 is bright, degrees")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(default=0.0, description="clockwise as displayed, degrees")
    low: Reflectance = Field(default=0.0, description=_LOW)
    high: Reflectance = Field(default=1.0, description=_HIGH)


class SineStar(Table):
    """A Siemens star of sinusoidal waves around its centre."""

    kind: Literal["sine-star"] = Field(description="which shape")
    radius: float = Field(gt=0, description="in the scene's unit")
    inner_radius: float = Field(gt=0, description="within which there is nothing of it, in the scene's unit")
    cycles: int = Field(ge=1, le=100_000, description="around it")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    rotate_deg: float = Field(
        default=0.0, description="of a bright middle from the right, clockwise as displayed, degrees"
    )
    low: Reflectance = Field(default=0.0, description=_LOW)
    high: Reflectance = Field(default=1.0, description=_HIGH)


class SineZonePlate(Table):
    """A disc of circular sinusoidal waves, ever finer towards its rim."""

    kind: Literal["sine-zone-plate"] = Field(description="which shape")
    radius: float = Field(gt=0, description="in the scene's unit")
    finest_period: float = Field(gt=0, description="of the waves at its rim, in the scene's unit")
    centre: Point = Field(default=(0.0, 0.0), description="from the optical axis, in the scene's unit")
    low: Reflectance = Field(default=0.0, description=_LOW)
    high: Reflectance = Field(default=1.0, description=_HIGH)
