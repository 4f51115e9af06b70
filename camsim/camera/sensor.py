"""A sensor without a lens, for light given as an array."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, Unpack, get_args

from numpy.typing import ArrayLike

from camsim.camera.body import Body
from camsim.camera.frame import Frame, Products
from camsim.camera.given_light import RELATIVE, GivenLight, Unit
from camsim.camera.shot import WHITE, Shot
from camsim.camera.window import Region
from camsim.core.doors import above
from camsim.core.typed import Number, Several, Truth, Whole
from camsim.core.words import brief, either
from camsim.errors import InvalidValueError
from camsim.optics import Lens, LowPass, OpticalStage, PhotositeShape
from camsim.optics.no_lens import NO_LENS
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.conversion_gain import DualGain
from camsim.sensor.electronics import ElectronicChanges
from camsim.sensor.exposure import Exposure
from camsim.sensor.falloff import Falloff
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import NumberOrCurve
from camsim.spectra.light import Light

_TIME_S = 0.01


def usual_exposure(iso: float, unit: Unit, time_s: float | Literal["auto"] | None = None) -> Exposure:
    """Return an exposure; the default time is "auto" for reflectances and 0.01 s for absolute units."""
    usual: float | Literal["auto"] = "auto" if unit in RELATIVE else _TIME_S
    return Exposure(time_s=usual if time_s is None else time_s, iso=iso)


@dataclass(frozen=True, kw_only=True)
class Sensor(Body):
    """A sensor without a lens: your light goes in, raw frames come out; for parameters see ``Camera``.

    Nothing blurs: neither lens nor OLPF act. Filters and quantum efficiency act if the light has a spectrum.

    >>> import numpy as np
    >>> import camsim
    >>> sensor = camsim.Sensor.from_yaml("d40-like")
    >>> frame = sensor.expose(np.full((4, 6), 1000.0), unit="electrons", seed=1)
    >>> frame.mosaic.shape, float(frame.mean_electrons.mean())
    ((4, 6), 1000.0)
    """

    lens: Lens = NO_LENS

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            name: str = "camera",
            serial: Whole = 1,
            rows: Whole,
            cols: Whole,
            pitch_um: Number,
            lens: Lens = NO_LENS,
            olpf: LowPass | None = None,
            photosite: PhotositeShape,
            cfa: Cfa,
            quantum_efficiency: QuantumEfficiency,
            colour_matrices: Several[MeasuredMatrix] = (),
            filters: Several[NumberOrCurve] = (),
            magnification: Number = 0.0,
            falloff: Falloff | None = None,
            veiling_glare: NumberOrCurve = 0.0,
            dual_gain: DualGain | None = None,
            adc: Adc,
            extra_optics: Several[OpticalStage] = (),
            **electronics: Unpack[ElectronicChanges],
        ) -> None: ...

    __repr__ = brief

    @classmethod
    def from_yaml(
        cls,
        sensor: str | os.PathLike[str],
        *,
        overrides: Iterable[str] = (),
        sensors: Iterable[str | os.PathLike[str]] = (),
    ) -> Sensor:
        """Return the sensor of a file (a path, or a shipped one's name); other arguments as of ``capture``."""
        camera = above("api.load_camera")(sensor, lens=NO_LENS, overrides=overrides, sensors=sensors)
        return cls(**{field.name: getattr(camera, field.name) for field in dataclasses.fields(cls)})

    def shot(
        self,
        image: ArrayLike | GivenLight,
        *,
        unit: Unit | None = None,
        wavelength_nm: Several[Number] | None = None,
        per_photosite: Whole = 1,
        light: Light = WHITE,
        exposure: Exposure | None = None,
        seed: Whole = 0,
        frame_number: Whole = 0,
        region: Region | None = None,
        noise: Truth = True,
        colour_matrix: MatrixOf = "standard",
    ) -> Shot:
        """Return the validated shot that ``expose`` takes, without exposing it."""
        if not isinstance(image, GivenLight):
            if unit is None:
                message = f"must be said of an array: {either(get_args(Unit))}"
                raise InvalidValueError(message, key="unit", stage="Sensor.expose")
            image = GivenLight(samples=image, unit=unit, wavelength_nm=wavelength_nm, per_photosite=per_photosite)
        elif unit is not None or wavelength_nm is not None or per_photosite != 1:
            message = "is said by the light that read_light gives; give it there"
            raise InvalidValueError(message, key="unit", stage="Sensor.expose")
        if exposure is None:
            exposure = usual_exposure(self.adc.base_iso, image.unit)
        return Shot(
            camera=self, image=image, light=light, exposure=exposure, seed=seed, frame_number=frame_number,
            region=region, noise=noise, colour_matrix=colour_matrix,
        )  # fmt: skip

    def expose(
        self,
        image: ArrayLike | GivenLight,
        *,
        unit: Unit | None = None,
        wavelength_nm: Several[Number] | None = None,
        per_photosite: Whole = 1,
        light: Light = WHITE,
        exposure: Exposure | None = None,
        seed: Whole = 0,
        frame_number: Whole = 0,
        region: Region | None = None,
        noise: Truth = True,
        colour_matrix: MatrixOf = "standard",
        products: Products | None = None,
    ) -> Frame:
        """Expose given light: no lens, no scene, nothing resampled.

        image    : an array, or the result of ``read_light``
        unit, wavelength_nm, per_photosite : of an array, as of ``GivenLight``; larger arrays are integrated
        light    : light on the sensor that a value of 1 stands for, in "reflectance" and "srgb"
        exposure : None: at the base ISO, "auto" for reflectances, 0.01 s (of dark current) for others
        region   : place of the light in the frame; None: the middle
        products : None: the mosaic, and the truth if the light determines every channel

        Other arguments as of ``Capture``.
        """
        shot = self.shot(
            image, unit=unit, wavelength_nm=wavelength_nm, per_photosite=per_photosite, light=light,
            exposure=exposure, seed=seed, frame_number=frame_number, region=region, noise=noise,
            colour_matrix=colour_matrix,
        )  # fmt: skip
        return shot.frame(products=products)
