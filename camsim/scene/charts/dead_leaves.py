"""Dead leaves: opaque discs of all sizes, a texture with the spectrum of natural pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, MinLen

from camsim.core.typed import Fraction, Point, Positive, Seed, Several
from camsim.scene.charts.chart import Many, chart, counted, instead, refused
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Disc
from camsim.spectra.curve import Reflectance


@chart
@instead(palette=("darkest", "lightest", "greys"))
def dead_leaves(
    *,
    width_um: Positive,
    height_um: Positive,
    least_radius_um: Positive,
    largest_radius_um: Positive,
    discs: Many | None = None,
    seed: Seed = 0,
    palette: Annotated[Several[Reflectance], MinLen(1)] | None = None,
    darkest: Fraction = 0.1,
    lightest: Fraction = 0.6,
    greys: Annotated[int, Ge(2), Le(4096)] = 64,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw discs with radii of a density r⁻³, each over those before it, with uniformly distributed reflectances.

    The power spectrum falls as 1/f² (ISO/TS 19567-2, IEEE 1858) between the frequencies of the largest and of the
    smallest discs: the wider the limits of the radii, the wider this range.

    width_um, height_um : size of the area that the texture covers; discs reach beyond it by up to the largest radius
    least_radius_um, largest_radius_um : limits of the radii
    discs    : number of discs, most of the first hidden by the last; when left out, so many that one place in 1000
               shows what lies behind all of them
    palette  : reflectances to draw from, such as a ColorChecker's
    darkest, lightest, greys : instead: limits and number of evenly spaced greys

    >>> len(dead_leaves(width_um=90.0, height_um=60.0, least_radius_um=1.0, largest_radius_um=20.0, discs=500).shapes)
    500
    """
    if largest_radius_um < least_radius_um:
        message = f"is {largest_radius_um:g}, less than least_radius_um, {least_radius_um:g}"
        raise refused(dead_leaves, "largest_radius_um", message)
    # Centres lie as far outside as a disc reaches: the texture inside does not know where it ends.
    room_um = np.array([width_um, height_um]) + 2.0 * largest_radius_um
    # The share of discs above r is (1/r² − 1/L²)/(1/l² − 1/L²).
    most, least = least_radius_um**-2.0, largest_radius_um**-2.0
    if discs is None:
        square_um2 = math.log(most / least) / (most - least) if most > least else least_radius_um**2
        discs = math.ceil(math.log(1000.0) * float(room_um[0] * room_um[1]) / (math.pi * square_um2))
    counted(dead_leaves, "least_radius_um", discs)
    colours: Several[Reflectance] = palette or np.linspace(darkest, lightest, greys).tolist()
    random = np.random.Generator(np.random.Philox(seed))
    radius_um = 1.0 / np.sqrt(least + (most - least) * random.random(discs))
    at_um = np.array(centre_um) + (random.random((discs, 2)) - 0.5) * room_um
    drawn = random.integers(len(colours), size=discs)
    yield from Disc.many(radius_um, at_um, (colours[colour] for colour in drawn.tolist()))
