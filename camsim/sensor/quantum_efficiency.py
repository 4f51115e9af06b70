"""QuantumEfficiency: electrons per photon, from curves that are mostly relative."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from annotated_types import Gt, Le

from camsim.arrays import F64
from camsim.errors import InvalidValueError
from camsim.marks import Called
from camsim.spectra.curve import Curve
from camsim.spectra.named import sensitivities
from camsim.typed import judge, refusal
from camsim.words import brief


@dataclass(frozen=True, slots=True)
class QuantumEfficiency:
    """Electrons per photon of every channel, filters of the sensor included.

    curves : (letter, curve) of each channel, in the order of ``channels``; their common scale is free
    per    : what the curves are a response to, equal radiant "energy" or equal numbers of "photon"s
    peak   : electrons per photon at the highest point of all channels, a fraction in 0..1
    source : where the curves and the peak come from

    Published sensitivities of colour cameras are mostly relative and per energy, data sheets' quantum
    efficiencies per photon. A response per energy is λ/hc times a quantum efficiency, so it is divided by λ
    before the peak is set: that moves the highest point towards the blue.

    >>> flat = Curve((400.0, 800.0), (1.0, 1.0))
    >>> nodes = np.array([400.0, 800.0])
    >>> QuantumEfficiency((("Y", flat),), per="energy", peak=0.6).at(nodes)
    array([[0.6, 0.3]])
    >>> QuantumEfficiency((("Y", flat),), per="photon", peak=0.6).at(nodes)
    array([[0.6, 0.6]])
    """

    curves: Annotated[Sequence[tuple[str, Curve]], Called("a list of (letter, Curve)")]
    per: Literal["energy", "photon"]
    peak: Annotated[float, Gt(0), Le(1)]
    source: str = ""

    __repr__ = brief

    def __post_init__(self) -> None:
        judge(self)
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
        if _highest(self) == 0.0:
            raise refusal(self, "curves", "all curves are zero; nothing can be seen")

    @classmethod
    def named(cls, name: str, *, peak: float, source: str = "") -> QuantumEfficiency:
        """Return those of a measured camera (``camsim list sensitivities``), whose curves are per energy."""
        return cls(_in_order(sensitivities(name)), per="energy", peak=peak, source=source)

    @property
    def channels(self) -> tuple[str, ...]:
        """The letters, one a channel."""
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
        part = _highest_of(chosen, self.per)
        return QuantumEfficiency(chosen, self.per, self.peak * part / _highest(self), self.source)

    def at(self, wavelength_nm: F64) -> F64:
        """Return (channels, n) electrons per photon at ``wavelength_nm`` (n,)."""
        relative = np.stack([curve.at(wavelength_nm) for _, curve in self.curves])
        if self.per == "energy":
            relative = relative / wavelength_nm
        efficiency: F64 = relative * (self.peak / _highest(self))
        return efficiency


def _highest(quantum_efficiency: QuantumEfficiency) -> float:
    return _highest_of(quantum_efficiency.curves, quantum_efficiency.per)


def _highest_of(curves: Sequence[tuple[str, Curve]], per: str) -> float:
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
