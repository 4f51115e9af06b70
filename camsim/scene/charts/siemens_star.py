"""The Siemens star of hard sectors: one frequency a radius, in every direction."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from annotated_types import Ge, Le

from camsim.scene.charts.chart import Card, chart, refused
from camsim.scene.primitives import Shape
from camsim.scene.shapes import Sector
from camsim.spectra.curve import Reflectance
from camsim.typed import NonNegative, Point, Positive


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

    radius_um : of the star
    cycles    : pairs of a dark and a light sector
    inner_radius_um : where the sectors begin; nothing is drawn inside
    rotate_deg : of the first dark sector's middle, clockwise as displayed from the right

    >>> star = siemens_star(radius_um=100.0, cycles=4)
    >>> len(star.shapes), star.shapes[0].from_deg, star.shapes[0].turn_deg
    (4, -22.5, 45.0)
    """
    if inner_radius_um >= radius_um:
        raise refused(siemens_star, "inner_radius_um", f"is {inner_radius_um:g}; it must be below {radius_um:g}")
    if light is not None:
        yield Card(centre_um).disc(radius_um, (0.0, 0.0), light)
    half = 90.0 / cycles
    for index in range(cycles):
        yield Sector(
            radius_um=radius_um,
            inner_radius_um=inner_radius_um,
            from_deg=rotate_deg + 360.0 * index / cycles - half,
            turn_deg=2.0 * half,
            centre_um=centre_um,
            reflectance=dark,
        )
