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
from camsim.sensor.checked import check_number, check_positive

# numpy's Poisson takes means up to about 9.2e18. No photosite holds a billionth of this.
_LARGEST_MEAN_E = 1e18

ABSOLUTE_ZERO_C = -273.15


@dataclass(frozen=True, slots=True)
class Prnu:
    """Photo-response non-uniformity: every photosite has a gain of its own, normal around 1.

    fraction : standard deviation of the gain, 0..1
    """

    fraction: float

    def __post_init__(self) -> None:
        check_number("prnu", "fraction", self.fraction, largest=1.0)

    def apply(self, electrons: F64, *, normals: F32) -> F64:
        """Multiply the mean charge by 1 + fraction · normals; a gain below 0 counts as 0.

        >>> normals = np.array([-1.0, 2.0], dtype=np.float32)
        >>> Prnu(0.01).apply(np.array([1000.0, 1000.0]), normals=normals).round(3)
        array([ 990., 1020.])
        """
        return electrons * _gain(self.fraction, normals)


@dataclass(frozen=True, slots=True)
class DarkCurrent:
    """Charge that gathers without light, on the mean; its shot noise comes with the light's.

    e_per_s       : electrons per second and photosite, the mean of all
    nonuniformity : standard deviation of its photosites (DCNU), a fraction of the mean
    at_c          : temperature at which ``e_per_s`` holds, °C
    doubling_c    : warming that doubles it, °C
    """

    e_per_s: float
    nonuniformity: float = 0.0
    at_c: float = 25.0
    doubling_c: float = 7.0

    def __post_init__(self) -> None:
        check_number("dark_current", "e_per_s", self.e_per_s)
        check_number("dark_current", "nonuniformity", self.nonuniformity, largest=1.0)
        check_temperature("dark_current", "at_c", self.at_c)
        if not 1.0 <= self.doubling_c <= 1000.0:
            raise InvalidValueError(f"dark_current: doubling_c {self.doubling_c}; must be 1..1000 °C (silicon: 5 to 9)")

    def warming(self, temperature_c: float | None) -> float:
        """Return how many times ``e_per_s`` the current is at a temperature (None: at ``at_c``).

        >>> DarkCurrent(1.0, at_c=20.0, doubling_c=6.0).warming(32.0)
        4.0
        """
        if temperature_c is None:
            return 1.0
        check_temperature("dark_current", "temperature_c", temperature_c)
        # Hotter than this no sensor is; the power of two stays finite.
        factor: float = 2.0 ** min((temperature_c - self.at_c) / self.doubling_c, 500.0)
        return factor

    def apply(
        self, electrons: F64, *, time_s: float, temperature_c: float | None = None, normals: F32 | None = None
    ) -> F64:
        """Add e_per_s · time_s to the mean charge, times 1 + nonuniformity · normals where those are given."""
        dark_e = self.e_per_s * time_s * self.warming(temperature_c)
        if normals is None:
            return electrons + dark_e
        return electrons + dark_e * _gain(self.nonuniformity, normals)


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
        check_positive("full_well", "capacity_e", self.capacity_e)

    def apply(self, electrons: F64) -> F64:
        """Cut the charge at the capacity."""
        held: F64 = np.minimum(electrons, self.capacity_e)
        return held


@dataclass(frozen=True, slots=True)
class ResetNoise:
    """kTC noise: what the reset of a capacitor leaves behind, normal; absent with correlated double sampling.

    sigma_e : standard deviation, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        check_number("reset_noise", "sigma_e", self.sigma_e)

    @classmethod
    def of_capacitance(cls, capacitance_ff: float, temperature_c: float = 25.0) -> ResetNoise:
        """Return the noise of a capacitance, √(kTC)/q (Boltzmann's k and the charge q: exact in the SI).

        >>> round(ResetNoise.of_capacitance(1.6).sigma_e, 1)
        16.0
        """
        check_number("reset_noise", "capacitance_ff", capacitance_ff)
        check_temperature("reset_noise", "temperature_c", temperature_c)
        energy_j = 1.380649e-23 * (temperature_c - ABSOLUTE_ZERO_C)
        return cls(math.sqrt(energy_j * capacitance_ff * 1e-15) / 1.602176634e-19)

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Add normal noise."""
        return _add_normals(electrons, self.sigma_e, rng.standard_normal(electrons.shape, dtype=np.float32))


@dataclass(frozen=True, slots=True)
class ReadNoise:
    """Normal noise of the read-out, referred to electrons.

    sigma_e : standard deviation, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        check_number("read_noise", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Add normal noise; charge may come out below zero."""
        return _add_normals(electrons, self.sigma_e, rng.standard_normal(electrons.shape, dtype=np.float32))


@dataclass(frozen=True, slots=True)
class RowNoise:
    """Every row of every frame has an offset of its own, normal around 0, independent of the other rows'.

    sigma_e : standard deviation, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        check_number("row_noise", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Add one number to each row (the first axis)."""
        return electrons + self.sigma_e * rng.standard_normal((len(electrons), 1))


@dataclass(frozen=True, slots=True)
class FlickerRows:
    """1/f noise of the supply, seen as bands: row offsets whose power falls with frequency.

    sigma_e  : standard deviation over the rows of a frame, electrons
    exponent : power ~ 1/frequency^exponent, 0..2; 1 is pink
    """

    sigma_e: float
    exponent: float = 1.0

    def __post_init__(self) -> None:
        check_number("flicker_rows", "sigma_e", self.sigma_e)
        check_number("flicker_rows", "exponent", self.exponent, largest=2.0)

    def offsets_e(self, rows: int, rng: np.random.Generator) -> F64:
        """Return (rows,) offsets of one frame, mean 0.

        White normals are shaped in the frequency domain of twice the frame (so that the last row knows nothing of
        the first) from one cycle per 2·rows up to Nyquist, and scaled to the expected variance.
        """
        if rows < 2:
            return np.zeros(rows)
        frequency = np.fft.rfftfreq(2 * rows)
        amplitude = np.zeros_like(frequency)
        amplitude[1:] = frequency[1:] ** (-0.5 * self.exponent)
        # Each frequency but Nyquist's stands for two of the full transform.
        power = (2.0 * np.sum(amplitude[1:-1] ** 2) + amplitude[-1] ** 2) / (2 * rows)
        white = np.fft.rfft(rng.standard_normal(2 * rows))
        shaped = np.fft.irfft(white * (amplitude / math.sqrt(power)), n=2 * rows)
        offsets: F64 = self.sigma_e * shaped[:rows]
        return offsets

    def apply(self, electrons: F64, *, rng: np.random.Generator) -> F64:
        """Add the offsets to the rows (the first axis) of a whole frame."""
        return electrons + self.offsets_e(len(electrons), rng)[:, None]


@dataclass(frozen=True, slots=True)
class ColumnNoise:
    """Every column's amplifier has an offset of its own, normal around 0: a fixed pattern of the sensor.

    sigma_e : standard deviation, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        check_number("column_noise", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, normals: F32) -> F64:
        """Add sigma_e · normals; normals (cols,) or anything that numpy stretches over the rows."""
        return electrons + self.sigma_e * normals.astype(np.float64)


@dataclass(frozen=True, slots=True)
class Dsnu:
    """Dark-signal non-uniformity: every photosite has an offset of its own, normal around 0.

    sigma_e : standard deviation of the offset, electrons
    """

    sigma_e: float

    def __post_init__(self) -> None:
        check_number("dsnu", "sigma_e", self.sigma_e)

    def apply(self, electrons: F64, *, normals: F32) -> F64:
        """Add sigma_e · normals."""
        return _add_normals(electrons, self.sigma_e, normals)


@dataclass(frozen=True, slots=True)
class OutputNoise:
    """Normal noise that comes in after the gain: the same in data numbers at every ISO.

    sigma_dn : standard deviation, data numbers
    """

    sigma_dn: float

    def __post_init__(self) -> None:
        check_number("output_noise", "sigma_dn", self.sigma_dn)

    def sigma_e(self, electrons_per_dn: float) -> float:
        """Return its standard deviation referred to electrons."""
        return self.sigma_dn * electrons_per_dn

    def apply(self, electrons: F64, *, electrons_per_dn: float, rng: np.random.Generator) -> F64:
        """Add normal noise, in electrons that stand for data numbers."""
        normals = rng.standard_normal(electrons.shape, dtype=np.float32)
        return _add_normals(electrons, self.sigma_e(electrons_per_dn), normals)


def check_temperature(stage: str, key: str, temperature_c: float) -> None:
    """Refuse a temperature that does not exist, or that no silicon survives."""
    if temperature_c < ABSOLUTE_ZERO_C:
        raise InvalidValueError(
            f"{stage}: {key} {temperature_c}; is below absolute zero, {ABSOLUTE_ZERO_C} °C (this is not in kelvin)"
        )
    if not temperature_c <= 1000.0:
        raise InvalidValueError(f"{stage}: {key} {temperature_c}; must be {ABSOLUTE_ZERO_C}..1000 °C")


def _gain(fraction: float, normals: F32) -> F64:
    """Return 1 + fraction · normals, nowhere below 0."""
    gain = fraction * normals.astype(np.float64)
    gain += 1.0
    raised: F64 = np.maximum(gain, 0.0, out=gain)
    return raised


def _add_normals(electrons: F64, sigma_e: float, normals: F32) -> F64:
    noisy: F64 = sigma_e * normals.astype(np.float64)
    noisy += electrons
    return noisy
