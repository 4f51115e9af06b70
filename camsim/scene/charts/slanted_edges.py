"""A grid of turned squares: slanted edges of several angles and contrasts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from annotated_types import MinLen

from camsim.core.typed import Point, Positive, Several
from camsim.scene.charts.chart import Card, Many, chart, counted
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
def slanted_edges(
    *,
    side_um: Positive,
    rows: Many = 1,
    cols: Many = 1,
    spacing_um: Positive | None = None,
    angles_deg: Annotated[Several[float], MinLen(1)] = (5.0,),
    dark: Annotated[Several[Reflectance], MinLen(1)] = (0.05,),
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw squares, each turned about its own centre; ``camsim measure mtf`` finds their edges.

    side_um    : side of a square
    rows, cols : number of squares down and across
    spacing_um : distance from centre to centre; twice the side when left out
    angles_deg : angles of the squares along each row, clockwise as displayed, repeated as needed
    dark       : reflectances of the squares down each column, repeated as needed

    >>> [shape.rotate_deg for shape in slanted_edges(side_um=100.0, cols=3, angles_deg=[3, 8]).shapes]
    [3.0, 8.0, 3.0]
    """
    counted(slanted_edges, "rows", rows * cols)
    card = Card(centre_um)
    step_um = 2.0 * side_um if spacing_um is None else spacing_um
    if light is not None:
        yield card.rectangle(cols * step_um, rows * step_um, (0.0, 0.0), light)
    for row in range(rows):
        for col in range(cols):
            at_um = ((col - 0.5 * (cols - 1)) * step_um, (row - 0.5 * (rows - 1)) * step_um)
            angle_deg, reflectance = angles_deg[col % len(angles_deg)], dark[row % len(dark)]
            yield card.rectangle(side_um, side_um, at_um, reflectance, angle_deg)
