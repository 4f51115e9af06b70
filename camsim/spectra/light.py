"""Light on the scene (or on the sensor): from a spectrum and a level to W/m² per nm."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from annotated_types import Ge, Le

from camsim.core.annotations import After
from camsim.core.arrays import F64, distinct
from camsim.core.typed import NonNegative, Number, Positive, refusal, validate
from camsim.core.words import LIGHT_NM, brief, either, percent, wavelength_hint
from camsim.errors import InvalidValueError, UnknownNameError
from camsim.spectra.curve import Curve, Spectrum
from camsim.spectra.integral import nodes_between
from camsim.spectra.named import illuminant, photopic_observer

# CODATA 2018; all three are exact in the SI of 2019.
PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_PER_S = 299_792_458.0
BOLTZMANN_J_PER_K = 1.380649e-23
# K_m for V(λ) in standard air: 683 lm/W is exact at 540 THz, which is 555.016 nm and not 555 nm (CIE S 010).
LUMINOUS_EFFICACY_LM_PER_W = 683.002

VISIBLE_NM = (360.0, 830.0)

# Range of silicon, used for thermal radiators.
_SILICON_NM = (300.0, 1100.0)
# A Gaussian line is truncated with 2e-9 of it in its tails, and integrated in panels of 1.5 standard deviations.
_LINE_SIGMAS, _LINE_PANELS, _LEAST_WIDTH_NM = 6.0, 8, 1e-6
# Degree of polynomials accurate to 1e-10 within such a panel, and for Planck's law at 500 K (the coldest) over 8 nm.
_LINE_DEGREE, _PLANCK_DEGREE = 10, 6
# Linear between the points of a table, times photons per joule, proportional to the wavelength.
_TABLE_DEGREE, _PHOTONS_DEGREE = 1, 1

_Spectrum: TypeAlias = Annotated[Curve, After(lambda curve: curve.going_on("zero"))]

# Less light than this outside a table is ignored.
_NEGLIGIBLE = 1e-3

_SPECTRA = ("spectrum", "line_nm", "blackbody_k")
_LEVELS = ("illuminance_lux", "irradiance_w_per_m2", "luminance_cd_per_m2")


@dataclass(frozen=True, eq=False)
class LightSamples:
    """A light's spectrum at quadrature nodes: ∫ f(λ) dλ = Σ weight_nm · f(wavelength_nm).

    wavelength_nm           (n,) increasing
    weight_nm               (n,) positive
    irradiance_w_per_m2_nm  (n,) on the scene, or on the sensor
    on_sensor               the irradiance is that behind the lens, from a reflectance of 1

    A line without width is one node of weight 1 nm that carries the whole irradiance.
    """

    wavelength_nm: F64
    weight_nm: F64
    irradiance_w_per_m2_nm: F64
    on_sensor: bool = False

    @property
    def photons_per_um2_s_nm(self) -> F64:
        """(n,) photons per µm², second and nm that fall on the scene (or the sensor)."""
        return self.irradiance_w_per_m2_nm * photons_per_um2_per_j_m2(self.wavelength_nm)


@dataclass(frozen=True, slots=True)
class Light:
    """One spectrum, scaled to one level.

    spectrum            : an illuminant's name ("D55") or a Curve of relative power per nm
    line_nm             : instead, one wavelength (a laser, say)
    width_nm            : width of that line, at half maximum of a Gaussian; 0: a single wavelength
    blackbody_k         : instead, a thermal radiator's temperature; it shines from 300 to 1100 nm
    illuminance_lux     : level, lux
    irradiance_w_per_m2 : instead, W/m² over the whole spectrum
    luminance_cd_per_m2 : instead, of a perfect diffuser in the scene, cd/m² (its illuminance is π times that)
    at                  : where the level holds: on the "scene", or on the "sensor" behind the lens for a reflectance
                          of 1 (then f-number, magnification and transmission of the lens dim nothing; filters do)

    >>> Light("D55", illuminance_lux=5000.0).ends_nm
    (300.0, 830.0)
    >>> Light(line_nm=555.0, illuminance_lux=1.0).samples().photons_per_um2_s_nm.round(1)
    array([4090.7])
    >>> Light(line_nm=850.0, irradiance_w_per_m2=0.2).samples().irradiance_w_per_m2_nm
    array([0.2])
    """

    spectrum: str | _Spectrum | None = None
    line_nm: Positive | None = field(default=None, kw_only=True)
    width_nm: NonNegative = field(default=0.0, kw_only=True)
    blackbody_k: Annotated[float, Ge(500), Le(1e6)] | None = field(default=None, kw_only=True)
    illuminance_lux: Positive | None = field(default=None, kw_only=True)
    irradiance_w_per_m2: Positive | None = field(default=None, kw_only=True)
    luminance_cd_per_m2: Positive | None = field(default=None, kw_only=True)
    at: Literal["scene", "sensor"] = field(default="scene", kw_only=True)

    if TYPE_CHECKING:

        def __init__(
            self,
            spectrum: str | Curve | None = None,
            *,
            line_nm: Number | None = None,
            width_nm: Number = 0.0,
            blackbody_k: Number | None = None,
            illuminance_lux: Number | None = None,
            irradiance_w_per_m2: Number | None = None,
            luminance_cd_per_m2: Number | None = None,
            at: Literal["scene", "sensor"] = "scene",
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        for keys, what in ((_SPECTRA, "spectrum"), (_LEVELS, "level")):
            given = [key for key in keys if getattr(self, key) is not None]
            if not given:
                raise refusal(self, keys[0], f"missing; a light has a {what}: give {either(keys)}")
            if len(given) > 1:
                message = f"given together with {given[0]}; a light has one {what}, leave one of the two out"
                raise refusal(self, given[1], message)
        if isinstance(self.spectrum, str):
            try:
                illuminant(self.spectrum)
            except UnknownNameError as error:
                raise UnknownNameError(error.kind, error.name, error.known, key="spectrum", stage="Light") from None
        if isinstance(self.spectrum, Curve) and not LIGHT_NM[0] <= self.spectrum.wavelength_nm[-1] <= LIGHT_NM[1]:
            last_nm, usual = self.spectrum.wavelength_nm[-1], f"give nm, {LIGHT_NM[0]:g} … {LIGHT_NM[1]:g}"
            raise refusal(self, "spectrum", f"ends at {last_nm:g} nm; {usual}{wavelength_hint(last_nm)}")
        if self.line_nm is not None:
            self._check_line(self.line_nm)
        elif self.width_nm != 0.0:
            raise refusal(self, "width_nm", "is a line's width; this light is no line")
        if self.at == "sensor" and self.luminance_cd_per_m2 is not None:
            raise refusal(self, "luminance_cd_per_m2", "belongs to the scene; on the sensor give illuminance_lux")
        _level_per_power(self)  # raises for dark light

    def _check_line(self, line_nm: float) -> None:
        visible = self.irradiance_w_per_m2 is None
        low, high = VISIBLE_NM if visible else LIGHT_NM
        if not low <= line_nm <= high:
            why = wavelength_hint(line_nm, low, high) or (
                ", because a line that the eye does not see has no illuminance; give irradiance_w_per_m2"
                if visible
                else ""
            )
            message = f"must be a number from {low:g} to {high:g}, not {line_nm:g}{why}"
            raise refusal(self, "line_nm", message)
        if self.width_nm > 0.2 * line_nm:
            message = f"must be at most {0.2 * line_nm:g} nm, a fifth of line_nm, not {self.width_nm:g}"
            raise refusal(self, "width_nm", message)

    @property
    def name(self) -> str:
        """Its name in reports: "D55", "line of 550 nm", "blackbody of 3000 K", the curve's own name."""
        if isinstance(self.spectrum, Curve):
            return self.spectrum.name or "table"
        if self.spectrum is not None:
            return self.spectrum
        if self.blackbody_k is not None:
            return f"blackbody of {self.blackbody_k:g} K"
        return f"line of {self.line_nm:g} nm" + (f", {self.width_nm:g} nm wide" if self.width_nm else "")

    @property
    def level(self) -> str:
        """The level with its unit: "5000 lx", "0.2 W/m²", "80 cd/m²"."""
        if self.irradiance_w_per_m2 is not None:
            return f"{self.irradiance_w_per_m2:g} W/m²"
        if self.luminance_cd_per_m2 is not None:
            return f"{self.luminance_cd_per_m2:g} cd/m²"
        return f"{self.illuminance_lux:g} lx"

    @property
    def total_w_per_m2(self) -> float:
        """Its level as irradiance over the whole spectrum.

        >>> round(Light(line_nm=555.0, illuminance_lux=683.0).total_w_per_m2, 3)
        1.0
        """
        return _level_per_power(self) / _level_per_power(self.of_one_watt)

    @property
    def of_one_watt(self) -> Light:
        """The same spectrum with a level of 1 W/m²."""
        return dataclasses.replace(self, illuminance_lux=None, luminance_cd_per_m2=None, irradiance_w_per_m2=1.0)

    @property
    def is_one_line(self) -> bool:
        """Whether it has a single wavelength: a line of zero or numerically unresolved width."""
        return self.line_nm is not None and self.width_nm < _LEAST_WIDTH_NM

    @property
    def ends_nm(self) -> tuple[float, float]:
        """The shortest and the longest wavelength of the spectrum."""
        kinks_nm = _shape(self).kinks_nm
        return kinks_nm[0], kinks_nm[-1]

    def irradiance_at(self, wavelength_nm: F64) -> F64:
        """Return W/m² per nm at ``wavelength_nm``; a line without width has all of its W/m² at its wavelength."""
        nodes, (first_nm, last_nm) = np.asarray(wavelength_nm, np.float64), self.ends_nm
        exposed = (first_nm <= nodes) & (nodes <= last_nm)
        irradiance: F64 = np.where(exposed, _level_per_power(self) * _shape(self).power(nodes), 0.0)
        return irradiance

    def samples(self, *stages: Iterable[Spectrum]) -> LightSamples:
        """Return the spectral irradiance at nodes that integrate its product with a curve of each stage exactly.

        stages : stages in the light path, each with alternative curves (the reflectances of a scene, the channels of a
                 sensor)

        Every point of every curve bounds a panel, so that narrow features and steps are resolved. Sums are integrals of
        the given curves, exact to rounding; for a line of finite width or a blackbody, to 1e-9.
        """
        nodes, weights = _nodes(self, stages)
        return LightSamples(nodes, weights, self.irradiance_at(nodes), self.at == "sensor")

    def beyond(self, curve: Curve) -> str:
        """Return a text on the light's wavelengths outside a curve's table, and their share; empty if negligible.

        >>> Light("D55", illuminance_lux=1.0).beyond(Curve((300.0, 700.0), (1.0, 1.0)))
        '700..830 nm is missing, with 30 % of the photons of D55'
        """
        first_nm, last_nm = curve.wavelength_nm[0], curve.wavelength_nm[-1]
        samples = self.samples([Curve((first_nm, last_nm), (1.0, 1.0))])
        photons, exposed_nm, parts = samples.weight_nm * samples.photons_per_um2_s_nm, self.ends_nm, []
        for outside, ends in (
            (samples.wavelength_nm < first_nm, (exposed_nm[0], first_nm)),
            (samples.wavelength_nm > last_nm, (last_nm, exposed_nm[1])),
        ):
            share = float(photons[outside].sum() / photons.sum())
            if share > 0.5 * _NEGLIGIBLE:
                words = f"{ends[0]:g}..{ends[1]:g} nm is missing, with {percent(share)} of the photons"
                parts.append((share, words))
        missing = " and ".join(words for _, words in parts)
        return f"{missing} of {self.name}" if sum(share for share, _ in parts) > _NEGLIGIBLE else ""


def photons_per_um2_per_j_m2(wavelength_nm: F64) -> F64:
    """Return how many photons per µm² make one J/m²: λ/hc, and 1e-12 m²/µm².

    >>> photons_per_um2_per_j_m2(np.array([555.0])).round(0)
    array([2793935.])
    """
    photons: F64 = np.asarray(wavelength_nm) * (1e-9 * 1e-12 / (PLANCK_J_S * LIGHT_SPEED_M_PER_S))
    return photons


def planck(wavelength_nm: F64, temperature_k: float) -> F64:
    """Return a thermal radiator's relative power per nm, 1 at 560 nm (Planck's law, vacuum wavelengths).

    >>> planck(np.array([560.0, 1120.0]), 2.897771955e6 / 560.0).round(4)
    array([1.    , 0.4054])
    """
    c2_nm = PLANCK_J_S * LIGHT_SPEED_M_PER_S / BOLTZMANN_J_PER_K * 1e9 / temperature_k
    power: F64 = (560.0 / wavelength_nm) ** 5 * (np.expm1(c2_nm / 560.0) / np.expm1(c2_nm / wavelength_nm))
    return power


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """A relative spectrum.

    kinks_nm : increasing, from the first to the last wavelength; smooth in between
    power    : W per nm between its ends, on any scale
    degree   : of the polynomials that approximate it between two kinks
    """

    kinks_nm: tuple[float, ...]
    power: Callable[[F64], F64]
    degree: int


def _shape(light: Light) -> _Shape:
    if light.line_nm is not None:
        centre_nm, sigma_nm = float(light.line_nm), light.width_nm / math.sqrt(8.0 * math.log(2.0))
        if light.is_one_line:
            return _Shape((centre_nm, centre_nm), np.ones_like, 0)
        steps = np.linspace(-_LINE_SIGMAS, _LINE_SIGMAS, _LINE_PANELS + 1)
        kinks_nm = tuple((centre_nm + sigma_nm * steps).tolist())
        return _Shape(kinks_nm, lambda nm: np.exp(-0.5 * ((nm - centre_nm) / sigma_nm) ** 2), _LINE_DEGREE)
    if light.blackbody_k is not None:
        kelvin = light.blackbody_k
        return _Shape(_SILICON_NM, lambda nm: planck(nm, kelvin), _PLANCK_DEGREE)
    assert light.spectrum is not None
    curve = light.spectrum if isinstance(light.spectrum, Curve) else illuminant(light.spectrum)
    kinks_nm = tuple(curve.wavelength_nm)
    if curve.outside == "hold":
        # At least the visible range.
        kinks_nm = tuple(sorted({*kinks_nm, min(kinks_nm[0], VISIBLE_NM[0]), max(kinks_nm[-1], VISIBLE_NM[1])}))
    return _Shape(kinks_nm, curve.at, _TABLE_DEGREE)


def _nodes(light: Light, stages: Iterable[Iterable[Spectrum]]) -> tuple[F64, F64]:
    """Return quadrature nodes and weights that resolve a light and all stages."""
    shape = _shape(light)
    first_nm, last_nm = shape.kinks_nm[0], shape.kinks_nm[-1]
    if light.is_one_line:
        return np.array([first_nm]), np.ones(1)
    kinks, degree = [np.array(shape.kinks_nm)], shape.degree + _PHOTONS_DEGREE
    for stage in stages:
        points = {spectrum.wavelength_nm for spectrum in stage if isinstance(spectrum, Curve)}
        kinks += map(np.array, points)
        degree += bool(points)
    breaks_nm = distinct(np.concatenate(kinks))
    return nodes_between(breaks_nm[(first_nm <= breaks_nm) & (breaks_nm <= last_nm)], degree)


@functools.lru_cache(maxsize=32)
def _level_per_power(light: Light) -> float:
    """Return W/m² per nm for a relative power of 1."""
    eye = photopic_observer() if light.irradiance_w_per_m2 is None else None
    nodes, weights = _nodes(light, [[eye or 1.0]])
    power = weights * _shape(light).power(nodes)
    if eye is None:
        whole = float(np.sum(power))
        if not whole > 0.0:
            raise InvalidValueError(f"{light.name!r} is dark: all of its values are 0", key="spectrum", stage="Light")
        return (light.irradiance_w_per_m2 or 0.0) / whole
    lux = LUMINOUS_EFFICACY_LM_PER_W * float(power @ eye.at(nodes))
    if lux <= 0.0:
        raise InvalidValueError(
            f"{light.name!r} holds nothing that the eye sees "
            f"({VISIBLE_NM[0]:g}..{VISIBLE_NM[1]:g} nm), so it cannot be scaled to an illuminance; "
            "give irradiance_w_per_m2",
            key="spectrum",
            stage="Light",
        )
    wanted_lux = light.illuminance_lux or math.pi * (light.luminance_cd_per_m2 or 0.0)
    return wanted_lux / lux
