"""Saturation of each channel, and its cause: the full well or the converter.

At full well there is no photon noise, as each photosite holds its capacity. At the converter's end, codes pile up at
the last one. Flats with neither are merely the brightest taken.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from camsim.measure.noise.estimate import SURE, Estimate, no_figure, over
from camsim.measure.noise.stack import Level, Stack

_FULL = 0.9
"""Share of codes at the converter's end, or of missing photon noise, above which the mean is nearly the saturation."""
_HEAPED, _NOISE_LEFT = 0.05, 0.7
"""Share of codes at the end, and of remaining photon noise, at which the brightest photosites become full."""


def saturation(brightest: Level, gain_dn_per_e: Estimate) -> Estimate:
    """Return the saturation signal of a channel in electrons, whether well or converter limits it."""
    if not gain_dn_per_e.measurable:
        return gain_dn_per_e
    photon_dn2 = gain_dn_per_e.value * brightest.signal_dn
    slack = SURE * brightest.added_sigma_dn2 / photon_dn2
    if not _at_converter(brightest.light):
        if slack > 0.5 * _FULL:
            return no_figure("noise hides whether the brightest flats are full; take more frames of them")
        if brightest.added_dn2 / photon_dn2 > 1.0 - _FULL + slack:
            return no_figure(
                f"the brightest flats, at exposure {brightest.exposure:g}, do not fill the channel; take clipped ones "
                "of more light"
            )
    return over(brightest.signal_dn, brightest.signal_sigma_dn, gain_dn_per_e)


def full_well(brightest: Level, gain_dn_per_e: Estimate) -> Estimate:
    """Return the signal of a channel whose wells are full, in electrons."""
    light, dark = brightest.light, brightest.dark
    if gain_dn_per_e.measurable and (light.at_end > _HEAPED or _at_converter(light)):
        reach_e = (light.largest_dn - dark.mean_dn) / gain_dn_per_e.value
        return no_figure(f"the converter ends at {reach_e:.0f} e⁻, before the well is full")
    return saturation(brightest, gain_dn_per_e)


def not_full(
    darks: Sequence[tuple[float, Stack]], brightest: Level, gain_dn_per_e: Estimate
) -> list[tuple[float, Stack]]:
    """Return the darks in which hardly any photosite is full; the mean of the others does not give the charge."""
    shortest = darks[0][1]
    if saturation(brightest, gain_dn_per_e).measurable:
        end_dn = brightest.light.mean_dn

        def sound(dark: Stack) -> bool:
            return dark.mean_dn + SURE * math.sqrt(dark.variance_dn2 + max(dark.pattern.dn2, 0.0)) < end_dn
    else:

        def sound(dark: Stack) -> bool:
            charge = Level(exposure=0.0, light=dark, dark=shortest)
            least_dn2 = _NOISE_LEFT * gain_dn_per_e.value * charge.signal_dn - SURE * charge.added_sigma_dn2
            return dark.at_end <= _HEAPED and charge.added_dn2 >= least_dn2

    return [(time_s, dark) for time_s, dark in darks if sound(dark)]


def _at_converter(light: Stack) -> bool:
    """Whether the converter limits the signal: all codes at or next to one, without read noise."""
    return light.at_end >= _FULL or light.variance_dn2 < light.rounding.least_dn2
