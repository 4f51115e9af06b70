"""Exposure and radiometry: from scene illumination to electrons in a photosite."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Literal

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import LONGEST_S, SHORTEST_S, Celsius, Iso, Number, Seconds, refusal, validate
from camsim.errors import InvalidValueError
from camsim.sensor.quantum_efficiency import QuantumEfficiency
from camsim.spectra.curve import Spectrum, spectrum_at
from camsim.spectra.light import LightSamples, photons_per_um2_per_j_m2

# Where "auto" puts a perfect diffuser: the brightest surface without a highlight keeps a quarter of headroom.
AUTO_LEVEL = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """Exposure time, ISO setting, temperature and date.

    time_s   : 1e-9 … 1e9, or "auto": a perfect diffuser puts the most responsive channel at 80 % of black..white
    iso      : sensitivity setting, 0.001 … 1e9; data numbers per electron grow in proportion to it
    datetime : date of the capture that files carry, "YYYY-MM-DD hh:mm:ss"
    temperature_c : of the sensor, °C; None: the temperature that its dark current is given for

    >>> Exposure(time_s=0.01, iso=200.0)
    Exposure(time_s=0.01, iso=200.0, datetime='2000-01-01 00:00:00', temperature_c=None)
    >>> Exposure(time_s="auto", iso=200.0).time_s
    'auto'
    """

    time_s: Seconds | Literal["auto"]
    iso: Iso
    datetime: str = "2000-01-01 00:00:00"
    temperature_c: Celsius | None = None

    if TYPE_CHECKING:

        def __init__(
            self,
            *,
            time_s: Number | Literal["auto"],
            iso: Number,
            datetime: str = "2000-01-01 00:00:00",
            temperature_c: Number | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        try:
            right = str(datetime.strptime(self.datetime, "%Y-%m-%d %H:%M:%S")) == self.datetime  # with leading zeros
        except ValueError:
            right = False
        if not right:
            message = f"must be a date and time such as '2000-01-31 23:59:59', not {self.datetime!r}"
            raise refusal(self, "datetime", message)


def sensor_irradiance_w_per_m2_nm(
    samples: LightSamples, *, f_number: float, transmission: Spectrum, opening: float = 1.0
) -> F64:
    """Return (n,) W/m²/nm on the sensor from a perfect diffuser: τ·E_scene/(4·N²), or the light if given on the sensor.

    A diffuser of irradiance E has radiance E/π, and an aplanatic lens of working f-number N focused far away
    turns a radiance L into π·L/(4·N²) on the axis (the scene is given as it falls on the sensor, so the
    magnification is in N).

    samples      : the light on the scene
    f_number     : working f-number N·(1 + m)
    transmission : fraction of the light that the lens passes
    opening      : area of the lens's pupil over that of a circle of diameter f/N
    """
    if samples.on_sensor:
        return samples.irradiance_w_per_m2_nm
    passes = opening * spectrum_at(transmission, samples.wavelength_nm)
    irradiance: F64 = passes * samples.irradiance_w_per_m2_nm / (4.0 * f_number**2)
    return irradiance


def electrons_per_reflectance(
    samples: LightSamples,
    *,
    f_number: float,
    transmission: Spectrum,
    quantum_efficiency: QuantumEfficiency,
    photosite_area_um2: float,
    time_s: float,
    filters: Sequence[Spectrum] = (),
    opening: float = 1.0,
) -> F64:
    """Return (channels, n) mean electrons per photosite for a reflectance of 1, quadrature weights included.

    Σ over n of this times a reflectance at the same nodes is the mean charge, electrons, of a photosite that
    receives only light of that surface.

    samples            : the light, at nodes that resolve all of these curves and the reflectance (``Light.samples``)
    photosite_area_um2 : light-sensitive area, pitch² × fill factor
    filters            : transmissions in front of the sensor, multiplied
    opening            : area of the lens's pupil over that of a circle of diameter f/N
    """
    photons_per_um2 = (
        sensor_irradiance_w_per_m2_nm(samples, f_number=f_number, transmission=transmission, opening=opening)
        * photons_per_um2_per_j_m2(samples.wavelength_nm)
        * samples.weight_nm
        * time_s
    )
    for filter_ in filters:
        photons_per_um2 = photons_per_um2 * spectrum_at(filter_, samples.wavelength_nm)
    electrons: F64 = quantum_efficiency.at(samples.wavelength_nm) * (photons_per_um2 * photosite_area_um2)
    return electrons


def auto_time_s(diffuser_e_per_s: F64, *, level_e: float) -> float:
    """Return the exposure time at which a perfect diffuser reaches a level in the channel where it is brightest.

    diffuser_e_per_s : (channels,) electrons per second and photosite of a perfect diffuser
    level_e          : electrons of that level, 80 % of black..white say

    Dark current is not included.

    >>> auto_time_s(np.array([1e5, 4e5, 2e5]), level_e=32_000.0)
    0.08
    """
    brightest = float(np.max(diffuser_e_per_s))
    if not brightest > 0.0:
        raise InvalidValueError(
            "auto, but no channel of the sensor responds to this light", key="time_s", stage="Exposure"
        )
    time_s = float(f"{level_e / brightest:.10g}")  # rounded, so that it is identical on every processor
    if not SHORTEST_S <= time_s <= LONGEST_S:
        more = "less" if time_s < SHORTEST_S else "more"
        raise InvalidValueError(
            f"auto would be {time_s:.3g} s in this light, outside {SHORTEST_S:g} … {LONGEST_S:g}; "
            f"give {more} light, or a time",
            key="time_s",
            stage="Exposure",
        )
    return time_s
