"""A figure with the standard deviation of its estimate, or a reason for its absence."""

from __future__ import annotations

import math
from dataclasses import dataclass

SURE = 4.0
"""Standard errors above which a figure is significant (chance: one in 30 000)."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A measured figure and the standard deviation of its estimate; or the reason why there is no figure.

    at_most : upper limit (4 standard errors) if the figure is not significant
    """

    value: float
    sigma: float
    why_not: str = ""
    at_most: float = math.inf

    @property
    def measurable(self) -> bool:
        """Whether there is a figure."""
        return not self.why_not


def no_figure(why_not: str, *, at_most: float = math.inf) -> Estimate:
    """Return a reason in place of a figure.

    >>> no_figure("black is clipped").measurable
    False
    """
    return Estimate(math.nan, math.nan, why_not, at_most)


def over(value_dn: float, sigma_dn: float, gain_dn_per_e: Estimate) -> Estimate:
    """Return a figure in codes converted to electrons.

    >>> over(100.0, 3.0, Estimate(0.5, 0.01))
    Estimate(value=200.0, sigma=7.211102550927978, why_not='', at_most=inf)
    """
    value, share = value_dn / gain_dn_per_e.value, gain_dn_per_e.sigma / gain_dn_per_e.value
    return Estimate(value, math.hypot(sigma_dn / gain_dn_per_e.value, value * share))


def root_over(squared_dn2: float, errors_dn2: tuple[float, float], gain_dn_per_e: Estimate) -> Estimate:
    """Return the root of a spatial variance in electrons; an upper limit if the variance is not significantly above 0.

    errors_dn2 : standard error of the variance, and its part due to temporal noise, all of it without a pattern

    Near 0 the root of a chance value is not small, and its relative error is not half of the variance's.

    >>> root_over(9.0, (0.6, 0.25), Estimate(1.0, 0.0)).sigma, root_over(-0.1, (0.6, 0.25), Estimate(1.0, 0.0)).at_most
    (0.09999999999999999, 1.0)
    """
    sigma_dn2, chance_dn2 = errors_dn2
    if squared_dn2 > SURE * chance_dn2:
        root_dn = math.sqrt(squared_dn2)
        return over(root_dn, 0.5 * sigma_dn2 / root_dn, gain_dn_per_e)
    return no_figure(
        f"noise gives as much by chance (the square is within {SURE:g} standard errors of 0); more frames tell more",
        at_most=math.sqrt(max(squared_dn2, 0.0) + SURE * chance_dn2) / gain_dn_per_e.value,
    )
