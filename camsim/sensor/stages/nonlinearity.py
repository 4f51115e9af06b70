"""Non-linear response: voltage that is not quite proportional to charge."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar, TypeAlias

import numpy as np

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, Positive, Several, refusal, validate
from camsim.core.words import brief
from camsim.sensor.stage import Context, ElectronicStage


@dataclass(frozen=True, slots=True)
class PolynomialResponse(ElectronicStage):
    """Response x·(1 + a₁u + a₂u² + …), u = x/scale_e: relative errors that grow with the charge.

    coefficients : a₁, a₂, …
    scale_e      : electrons at which u is 1, such as the full well; continued linearly by its tangent above

    The response must rise everywhere from 0 to scale_e.

    >>> PolynomialResponse((-0.02,), scale_e=10_000.0).response(np.array([0.0, 5000.0, 10_000.0, 11_000.0]))
    array([    0.,  4950.,  9800., 10760.])
    """

    name: ClassVar = "nonlinearity"
    without_noise: ClassVar = True

    coefficients: Several[float]
    scale_e: Positive

    if TYPE_CHECKING:

        def __init__(self, coefficients: Several[Number], scale_e: Number) -> None: ...

    def __post_init__(self) -> None:
        validate(self)
        if not len(self.coefficients):
            raise refusal(self, "coefficients", "must be one or more numbers, not none")
        u = np.linspace(0.0, 1.0, 1001)
        slope = np.polynomial.Polynomial(self._of_u).deriv()(u)
        if slope.min() <= 0.0:
            falls = f"the response falls at {u[slope.argmin()] * self.scale_e:g} e⁻"
            message = f"{list(self.coefficients)}; more charge must give more signal up to scale_e, but {falls}"
            raise refusal(self, "coefficients", message)

    @property
    def _of_u(self) -> list[float]:
        return [0.0, 1.0, *self.coefficients]

    def apply(self, electrons: F64, context: Context) -> F64:
        """Bend the signal."""
        return self.response(electrons)

    def response(self, electrons: F64) -> F64:
        """Return the electrons that a linear read-out would have called this signal."""
        u = electrons / self.scale_e
        inside = np.minimum(u, 1.0)
        relative = np.zeros_like(inside)
        for coefficient in reversed(self.coefficients):
            relative += coefficient
            relative *= inside
        bent: F64 = electrons * (1.0 + relative)
        beyond = u > 1.0
        if beyond.any():
            end_slope = float(np.polynomial.Polynomial(self._of_u).deriv()(1.0))
            at_end = 1.0 + sum(self.coefficients)
            bent[beyond] = self.scale_e * (at_end + end_slope * (u[beyond] - 1.0))
        return bent


@dataclass(frozen=True, slots=True)
class ResponseTable(ElectronicStage):
    """Response by a table, straight between its points and beyond them.

    electrons_in  : (n,) charge, increasing from 0, at least two
    electrons_out : (n,) electrons as read, under the assumption of linearity, increasing from 0

    >>> ResponseTable((0.0, 1000.0, 2000.0), (0.0, 1000.0, 1900.0)).response(np.array([500.0, 1500.0, 3000.0]))
    array([ 500., 1450., 2800.])
    """

    name: ClassVar = "nonlinearity"
    without_noise: ClassVar = True

    electrons_in: Several[NonNegative]
    electrons_out: Several[NonNegative]

    if TYPE_CHECKING:

        def __init__(self, electrons_in: Several[Number], electrons_out: Several[Number]) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        for key in ("electrons_in", "electrons_out"):
            values = getattr(self, key)
            if len(values) < 2:
                raise refusal(self, key, f"must be two or more numbers, not {len(values)}")
            if any(after <= before for before, after in pairwise(values)):
                raise refusal(self, key, f"{list(values)}; must increase: more charge gives more signal")
            if values[0] != 0.0:
                raise refusal(self, key, f"{list(values)}; must begin with 0: no charge is black")
        if len(self.electrons_in) != len(self.electrons_out):
            message = (
                f"{len(self.electrons_out)} for {len(self.electrons_in)} electrons_in; every point has one of each"
            )
            raise refusal(self, "electrons_out", message)

    def apply(self, electrons: F64, context: Context) -> F64:
        """Bend the signal."""
        return self.response(electrons)

    def response(self, electrons: F64) -> F64:
        """Return the electrons that a linear read-out would have called this signal."""
        x, y = np.array(self.electrons_in, np.float64), np.array(self.electrons_out, np.float64)
        bent: F64 = np.interp(electrons, x, y)
        first, last = ((y[b] - y[a]) / (x[b] - x[a]) for a, b in ((0, 1), (-2, -1)))
        bent += first * np.minimum(electrons - x[0], 0.0)
        bent += last * np.maximum(electrons - x[-1], 0.0)
        return bent


Nonlinearity: TypeAlias = PolynomialResponse | ResponseTable


def charge_e(bends: Nonlinearity, signal_e: float) -> float:
    """Return the charge that a non-linear response turns into a given signal.

    >>> round(charge_e(PolynomialResponse((-0.02,), scale_e=10_000.0), 4950.0), 9)
    5000.0
    """

    from scipy.optimize import brentq  # imported here, as it takes 0.1 s that linear sensors do not need

    def over(charge: float) -> float:
        return float(bends.response(np.array([charge]))[0]) - signal_e

    most = max(signal_e, 1.0)
    while over(most) < 0.0:  # the response rises without bound
        most *= 2.0
    found: float = brentq(over, 0.0, most, xtol=1e-12 * most)
    return found
