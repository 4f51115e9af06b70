"""The Siemens star of hard sectors: at each radius one frequency, in every direction."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Ge, Le

from camsim.core.typed import NonNegative, Point, Positive
from camsim.scene.charts.chart import Card, chart, refused
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Path
from camsim.spectra.curve import Reflectance

# The card extends beyond the sectors: coincident round outlines would be cut more finely.
_RIM = 1.05


@chart
def siemens_star(
    *,
    radius_um: Positive,
    cycles: Annotated[int, Ge(2), Le(10_000)] = 72,
    inner_radius_um: NonNegative = 0.0,
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw dark sectors: at radius r they have cycles/(2π·r) line pairs per length.

    ISO 12233 recommends 144 or 72 cycles, sinusoidal; these are hard, and their fundamental has 4/π of the contrast.

    radius_um : radius of the star; that of the card is 5 % larger
    cycles    : number of pairs of a dark and a light sector
    inner_radius_um : where the sectors begin; nothing is drawn inside
    rotate_deg : direction of the first dark sector's middle, clockwise as displayed from the right

    >>> star = siemens_star(radius_um=100.0, cycles=4)
    >>> star.pieces  # of each sector two sides and an arc
    12
    """
    if inner_radius_um >= radius_um:
        raise refused(siemens_star, "inner_radius_um", f"is {inner_radius_um:g}; it must be below {radius_um:g}")
    if light is not None:
        yield Card(centre_um).disc(_RIM * radius_um, (0.0, 0.0), light)
    yield Path(segments_um=list(_sectors(cycles, radius_um, inner_radius_um, rotate_deg, centre_um)), reflectance=dark)


def _sectors(
    cycles: int, radius_um: float, inner_um: float, rotate_deg: float, centre_um: Point
) -> Iterator[tuple[str | float, ...]]:
    """Yield the outlines of all sectors: as one path they take a tenth of the time of many touching shapes."""
    x, y = centre_um
    for index in range(cycles):
        middle = math.radians(rotate_deg) + math.tau * index / cycles
        before, after = (
            (math.cos(middle + side * 0.5 * math.pi / cycles), math.sin(middle + side * 0.5 * math.pi / cycles))
            for side in (-1.0, 1.0)
        )
        yield "move", x + inner_um * before[0], y + inner_um * before[1]
        yield "line", x + radius_um * before[0], y + radius_um * before[1]
        yield "arc", radius_um, radius_um, 0.0, 0.0, 1.0, x + radius_um * after[0], y + radius_um * after[1]
        if inner_um > 0.0:
            yield "line", x + inner_um * after[0], y + inner_um * after[1]
            yield "arc", inner_um, inner_um, 0.0, 0.0, 0.0, x + inner_um * before[0], y + inner_um * before[1]
        yield ("close",)
