"""QuantumEfficiency: electrons per photon, from absolute or relative curves."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from annotated_types import Gt, Le

from camsim.core.annotations import Called
from camsim.core.arrays import F64
from camsim.core.typed import Number, refusal, validate
from camsim.core.words import brief
from camsim.errors import InvalidValueError
from camsim.sensor.cfa import GREENS
from camsim.spectra.curve import Curve
from camsim.spectra.light import LIGHT_SPEED_M_PER_S, PLANCK_J_S
from camsim.spectra.named import sensitivities

ELECTRON_CHARGE_C = 1.602176634e-19
"""Exact in the SI of 2019."""


@dataclass(frozen=True, slots=True)
class QuantumEfficiency:
    """Electrons per photon of every channel, filters of the sensor included.

    curves : (letter, curve) of each channel, in the order of ``channels``; their common scale is free. "Gr" and "Gb",
             stored as G and g, are the greens in rows with red and in rows with blue
    per    : unit of the response: per radiant "energy" or per "photon"
    peak   : electrons per photon at the highest point of all channels, a fraction in 0..1; "as given" of curves that
             are absolute: electrons per photon, or amperes per watt where they are per energy
    source : where the curves and the peak come from

    Published sensitivities of colour cameras are mostly relative and per energy, data sheets' quantum
    efficiencies per photon. A response per energy is λ/hc times a quantum efficiency, so it is divided by λ
    before the peak is set, which moves the maximum towards the blue.

    >>> flat = Curve((400.0, 800.0), (1.0, 1.0))
    >>> nodes = np.array([400.0, 800.0])
    >>> QuantumEfficiency((("Y", flat),), per="energy", peak=0.6).at(nodes)
    array([[0.6, 0.3]])
    >>> QuantumEfficiency((("Y", flat),), per="photon", peak=0.6).at(nodes)
    array([[0.6, 0.6]])
    >>> responsivity = Curve((400.0, 800.0), (0.2, 0.4))
    >>> QuantumEfficiency((("Y", responsivity),), per="energy", peak="as given").at(nodes).round(4)
    array([[0.6199, 0.6199]])
    """

    curves: Annotated[Sequence[tuple[str, Curve]], Called("a list of (letter, Curve)")]
    per: Literal["energy", "photon"]
    peak: Annotated[float, Gt(0), Le(1)] | Literal["as given"]
    source: str = ""

    if TYPE_CHECKING:

        def __init__(
            self,
            curves: Sequence[tuple[str, Curve]],
            per: Literal["energy", "photon"],
            peak: Number | Literal["as given"],
            source: str = "",
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        named = tuple((GREENS.get(letter, letter), curve) for letter, curve in self.curves)
        object.__setattr__(self, "curves", named)
        if not self.curves:
            raise refusal(self, "curves", "no curves; every channel needs one")
        for letter in self.channels:
            if not (len(letter) == 1 and letter.isascii() and letter.isalpha()):
                raise refusal(self, "curves", f"channel {letter!r}; a channel is one letter, such as 'R'")
        if len(set(self.channels)) != len(self.channels):
            raise refusal(self, "curves", f"channels {''.join(self.channels)} name a letter twice")
        held = [letter for letter, curve in self.curves if curve.outside == "hold"]
        if held and self.per == "energy":
            message = (
                f"the curve of {', '.join(held)} is held beyond its table; a response per energy that goes on to "
                "shorter wavelengths has no peak: use outside 'zero', or curves per photon"
            )
            raise refusal(self, "curves", message)
        highest = _highest(self)
        if highest == 0.0:
            raise refusal(self, "curves", "all curves are zero; nothing can be seen")
        if self.peak == "as given" and highest * _absolute(self.per) > 1.0:
            unit = "electrons per photon, fractions" if self.per == "photon" else "amperes per watt"
            reached = f"as given they reach {highest * _absolute(self.per):.4g} electrons per photon"
            message = f"{reached}, and 1 is the most; give {unit}, or a peak to scale them to"
            raise refusal(self, "curves", message)

    @classmethod
    def named(cls, name: str, *, peak: Number, source: str = "") -> QuantumEfficiency:
        """Return the efficiencies of a measured camera (``camsim list sensitivities``), whose curves are per energy."""
        return cls(_in_order(sensitivities(name)), per="energy", peak=peak, source=source)

    @property
    def channels(self) -> tuple[str, ...]:
        """The letters, one per channel."""
        return tuple(letter for letter, _ in self.curves)

    def select(self, channels: tuple[str, ...]) -> QuantumEfficiency:
        """Return the same efficiencies for these channels only, in this order; the scale stays."""
        known = dict(self.curves)
        missing = [letter for letter in channels if letter not in known]
        if missing:
            raise InvalidValueError(
                f"no curve for {', '.join(missing)}; there are {', '.join(known)}",
                key="curves",
                stage="QuantumEfficiency",
            )
        chosen = tuple((letter, known[letter]) for letter in channels)
        if isinstance(self.peak, str):
            return QuantumEfficiency(chosen, self.per, self.peak, self.source)
        part = _highest_of(chosen, self.per)
        return QuantumEfficiency(chosen, self.per, self.peak * part / _highest(self), self.source)

    def at(self, wavelength_nm: F64) -> F64:
        """Return (channels, n) electrons per photon at ``wavelength_nm`` (n,)."""
        relative = np.stack([curve.at(wavelength_nm) for _, curve in self.curves])
        if self.per == "energy":
            relative = relative / wavelength_nm
        scale = _absolute(self.per) if isinstance(self.peak, str) else self.peak / _highest(self)
        efficiency: F64 = relative * scale
        return efficiency


def _absolute(per: str) -> float:
    """Return electrons per photon of a response of 1 per photon, or of 1 A/W at 1 nm: hc over charge and wavelength."""
    return PLANCK_J_S * LIGHT_SPEED_M_PER_S / ELECTRON_CHARGE_C * 1e9 if per == "energy" else 1.0


def _highest(quantum_efficiency: QuantumEfficiency) -> float:
    return _highest_of(tuple(quantum_efficiency.curves), quantum_efficiency.per)


@functools.lru_cache(maxsize=64)
def _highest_of(curves: tuple[tuple[str, Curve], ...], per: str) -> float:
    """Return the highest response per photon.

    On each straight piece a + bλ the response per photon is a + bλ or a/λ + b: monotone, so the highest
    point of the whole curve is one of the table's.
    """
    highest: float = max(
        value / wavelength if per == "energy" else value
        for _, curve in curves
        for wavelength, value in zip(curve.wavelength_nm, curve.values, strict=True)
    )
    return highest


def _in_order(curves: Mapping[str, Curve]) -> tuple[tuple[str, Curve], ...]:
    return tuple((letter, curves[letter]) for letter in "RGB" if letter in curves)
