"""Noise stages: small frozen objects with one verb, ``apply``; electrons in, electrons out.

Randomness comes in as an argument. Temporal stages take a Generator; fixed patterns take the standard normals
that belong to the sensor's photosites (``camsim.sensor.streams.fixed_normals``). ``chain.record`` applies all
of them in physical order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F32, F64
from camsim.errors import InvalidValueError

# numpy's Poisson takes means up to about 9.2e18. No photosite holds a billionth of this.
_LARGEST_MEAN_E = 1e18


@dataclass(frozen=True, slots=True)
class Prnu:
    """Photo-response non-uniformity: every photosite has a gain of its own, normal around 1.

    fraction : standard deviation of the gain, 0..1
    """

    fraction: float

    def __post_init__(self) -> None:
        _check("prnu", "fraction", self.fraction, largest=1.0)

    def apply(self, electrons: F64, *, normals: F32) -> F64:
        """Multiply the mean charge by 1 + fraction · normals; a gain below 0 counts as 0.

        >>> normals = np.array([-1.0, 2.0], dtype=np.float32)
        >>> Prnu(0.01).apply(np.array([1000.0, 1000.0]), normals=normals).round(3)
        array([ 990., 1020.])
        """
        gain = 1.0 + self.fraction * normals.astype(np.float64)
        lit: F64 = electrons * np.maximum(gain, 0.0, out=gain)
        return lit


@dataclass(frozen=True, slots=True)
class DarkCurrent:
    """Charge that gathers without light, on the mean; its shot noise comes with the light's.

    e_per_s : electrons per second and photosite
    """

    e_per_s: float

    def __post_init__(self) -> None:
        _check("dark_current", "e_per_s", self.e_per_s)

    def apply(self, electrons: F64, *, time_s: float) -> F64:
        """Add e_per_s · time_s to the mean charge."""
        return electrons + self.e_per_s * time_s


@dataclass(frozen=True, slots=True)
class ShotNoise:
    """Photons and dark electrons arrive one by one: a Poisson count of the mean charge."""

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Replace mean charge by a count, Poisson at any mean (to rounding: above 1e13 its spread suffers).

        A mean below zero (a rendering may be, by its tolerance) counts as zero.

        >>> ShotNoise().apply(np.array([0.0, -1e-9]), rng=np.random.default_rng(1))
        array([0., 0.])
        """
        return rng.poisson(np.clip(electrons, 0.0, _LARGEST_MEAN_E)).astype(np.float64)


@dataclass(frozen=True, slots=True)
class FullWell:
    """A photosite holds so many electrons and no more.

    capacity_e : electrons, above 0
    """

    capacity_e: float

    def __post_init__(self) -> None:
        _check("full_well", "capacity_e", self.capacity_e)
        if self.capacity_e == 0.0:
            raise InvalidValueError("full_well: capacity_e 0; must be above 0")

    def apply(self, electrons: F64) -> F64:
        """Cut the charge at the capacity."""
        held: F64 = np.minimum(electrons, self.capacity_e)
        return held


@dataclass(frozen=True, slots=True)
class ReadNoise:
    """Normal noise of the read-out, referred to electrons.

    sigma_e : standard deviation, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        _check("read_noise", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Add normal noise; charge may come out below zero."""
        return _add_normals(electrons, self.sigma_e, rng.standard_normal(electrons.shape, dtype=np.float32))


@dataclass(frozen=True, slots=True)
class Dsnu:
    """Dark-signal non-uniformity: every photosite has an offset of its own, normal around 0.

    sigma_e : standard deviation of the offset, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        _check("dsnu", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, normals: F32) -> F64:
        """Add sigma_e · normals."""
        return _add_normals(electrons, self.sigma_e, normals)


def _add_normals(electrons: F64, sigma_e: float, normals: F32) -> F64:
    noisy: F64 = sigma_e * normals.astype(np.float64)
    noisy += electrons
    return noisy


def _check(stage: str, key: str, value: float, largest: float = math.inf) -> None:
    if not (math.isfinite(value) and 0.0 <= value <= largest):
        allowed = "0 or more" if largest == math.inf else f"a fraction in 0..{largest:g} (0.01 means 1 %)"
        raise InvalidValueError(f"{stage}: {key} {value}; must be {allowed}, and finite")
