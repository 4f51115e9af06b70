"""A zone plate of hard rings: every frequency up to the rim's, in every direction."""

from __future__ import annotations

import math
from collections.abc import Iterator

from camsim.core.typed import Point, Positive
from camsim.scene.charts.chart import Card, chart, counted, periods
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
def zone_plate(
    *,
    radius_um: Positive,
    rim_lp_per_mm: Positive | None = None,
    rim_period_um: Positive | None = None,
    dark: Reflectance = 0.05,
    light: Reflectance = 0.9,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw rings that are dark where cos(π·r²·f/R) < 0: at radius r the frequency is f·r/R, at the rim R it is f.

    radius_um     : radius of the rim
    rim_lp_per_mm : frequency at the rim, line pairs per mm on the sensor
    rim_period_um : instead: length of a line pair at the rim
    light         : reflectance of the rings between the dark ones, and of the middle

    >>> [round(disc.radius_um, 2) for disc in zone_plate(radius_um=100.0, rim_period_um=50.0).shapes]
    [100.0, 86.6, 50.0]
    """
    (period_um,) = periods(
        zone_plate,
        None if rim_lp_per_mm is None else (rim_lp_per_mm,),
        None if rim_period_um is None else (rim_period_um,),
        ("rim_lp_per_mm", "rim_period_um"),
    )
    # The phase r²·f/R grows by 1 a ring, and the first boundary is at 1/2.
    boundaries = math.floor(radius_um / period_um + 0.5)
    counted(zone_plate, "rim_period_um" if rim_lp_per_mm is None else "rim_lp_per_mm", boundaries)
    card = Card(centre_um)
    radii = [math.sqrt((index + 0.5) * period_um * radius_um) for index in range(boundaries)]
    if not radii or radii[-1] < radius_um:
        radii.append(radius_um)
    # Each disc covers all of the previous one except a ring.
    for index in reversed(range(len(radii))):
        yield card.disc(radii[index], (0.0, 0.0), dark if index % 2 else light)
