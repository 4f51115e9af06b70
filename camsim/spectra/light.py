"""Light: what falls on the scene, from a spectrum and an illuminance to W/m² per nm."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.spectra.curve import Curve
from camsim.spectra.named import illuminant, photopic_observer

# CODATA 2018; all three are exact in the SI of 2019.
PLANCK_J_S = 6.62607015e-34
LIGHT_SPEED_M_PER_S = 299_792_458.0
# K_m for V(λ) in standard air: 683 lm/W is exact at 540 THz, which is 555.016 nm and not 555 nm (CIE S 010).
LUMINOUS_EFFICACY_LM_PER_W = 683.002

VISIBLE_NM = (360.0, 830.0)


@dataclass(frozen=True, eq=False)
class LightSamples:
    """A light's spectrum at quadrature nodes: ∫ f(λ) dλ ≈ Σ weight_nm · f(wavelength_nm).

    wavelength_nm           (n,) increasing
    weight_nm               (n,) positive
    irradiance_w_per_m2_nm  (n,) on the scene

    A line is one node of weight 1 nm that carries the whole irradiance.
    """

    wavelength_nm: F64
    weight_nm: F64
    irradiance_w_per_m2_nm: F64

    @property
    def photons_per_um2_s_nm(self) -> F64:
        """(n,) photons per µm², second and nm that fall on the scene."""
        return self.irradiance_w_per_m2_nm * photons_per_um2_per_j_m2(self.wavelength_nm)


@dataclass(frozen=True, slots=True)
class Light:
    """The light on the scene: an illuminant, a line or a table, scaled to an illuminance.

    spectrum        : an illuminant's name ("D55") or a Curve of relative power per nm
    line_nm         : instead of a spectrum, one wavelength
    illuminance_lux : on the scene, above 0

    >>> Light("D55", illuminance_lux=5000.0).samples().wavelength_nm[[0, -1]]
    array([300., 780.])
    >>> Light(line_nm=555.0, illuminance_lux=1.0).samples().photons_per_um2_s_nm.round(1)
    array([4090.7])
    """

    spectrum: str | Curve | None = None
    line_nm: float | None = field(default=None, kw_only=True)
    illuminance_lux: float = field(kw_only=True)

    def __post_init__(self) -> None:
        if (self.spectrum is None) == (self.line_nm is None):
            raise InvalidValueError("a light is either a spectrum or a line_nm: give exactly one of the two")
        if not (math.isfinite(self.illuminance_lux) and self.illuminance_lux > 0.0):
            raise InvalidValueError(f"illuminance_lux {self.illuminance_lux}; must be above 0 and finite")
        if self.line_nm is not None and not (VISIBLE_NM[0] <= self.line_nm <= VISIBLE_NM[1]):
            raise InvalidValueError(
                f"line_nm {self.line_nm}; must be {VISIBLE_NM[0]:g}..{VISIBLE_NM[1]:g} nm, "
                "because a line that the eye does not see has no illuminance"
            )

    @property
    def name(self) -> str:
        """What to call it in reports: "D55", "line of 550 nm", the curve's own name."""
        if isinstance(self.spectrum, Curve):
            return self.spectrum.name or "table"
        return self.spectrum if self.spectrum is not None else f"line of {self.line_nm:g} nm"

    def samples(self) -> LightSamples:
        """Return the spectral irradiance on the scene at quadrature nodes (arrays are read-only)."""
        return _samples(self)


def photons_per_um2_per_j_m2(wavelength_nm: F64) -> F64:
    """Return how many photons per µm² make one J/m²: λ/hc, and 1e-12 m²/µm².

    >>> photons_per_um2_per_j_m2(np.array([555.0])).round(0)
    array([2793935.])
    """
    photons: F64 = np.asarray(wavelength_nm) * (1e-9 * 1e-12 / (PLANCK_J_S * LIGHT_SPEED_M_PER_S))
    return photons


@functools.lru_cache(maxsize=32)
def _samples(light: Light) -> LightSamples:
    if light.line_nm is not None:
        wavelength_nm, weight_nm, power = np.array([light.line_nm]), np.ones(1), np.ones(1)
    else:
        assert light.spectrum is not None
        curve = light.spectrum if isinstance(light.spectrum, Curve) else illuminant(light.spectrum)
        wavelength_nm = _nodes_nm(curve)
        weight_nm = _weights_nm(wavelength_nm)
        power = curve.at(wavelength_nm)
    lux = LUMINOUS_EFFICACY_LM_PER_W * np.sum(weight_nm * power * photopic_observer().at(wavelength_nm))
    if lux <= 0.0:
        raise InvalidValueError(
            f"light {light.name!r} holds nothing that the eye sees "
            f"({VISIBLE_NM[0]:g}..{VISIBLE_NM[1]:g} nm), so it cannot be scaled to an illuminance"
        )
    samples = LightSamples(wavelength_nm, weight_nm, power * (light.illuminance_lux / lux))
    for array in (samples.wavelength_nm, samples.weight_nm, samples.irradiance_w_per_m2_nm):
        array.setflags(write=False)
    return samples


def _nodes_nm(curve: Curve) -> F64:
    """Return whole nanometres and the table's own points, from its first to its last (held: all the visible).

    With every kink of the light at a node, nothing narrower than 1 nm is missed.
    """
    first_nm, last_nm = curve.wavelength_nm[0], curve.wavelength_nm[-1]
    if curve.outside == "hold":
        first_nm, last_nm = min(first_nm, VISIBLE_NM[0]), max(last_nm, VISIBLE_NM[1])
    whole = np.arange(math.ceil(first_nm), math.floor(last_nm) + 1, dtype=np.float64)
    nodes: F64 = np.union1d(whole, [first_nm, *curve.wavelength_nm, last_nm])
    return nodes


def _weights_nm(wavelength_nm: F64) -> F64:
    """Return what each node stands for: half the way to its neighbours, and 0.5 nm beyond the first and last.

    On whole nanometres every weight is 1, which is how CIE 15 sums spectra: a table that ends abruptly at
    780 nm ends at 780.5 nm.
    """
    half_step = np.concatenate([[0.5], np.diff(wavelength_nm) / 2, [0.5]])
    weights: F64 = half_step[:-1] + half_step[1:]
    return weights
