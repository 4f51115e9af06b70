"""What repeats along both axes: the checkerboard, the grid of dots, and the grid of slanted edges."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from annotated_types import MinLen

from camsim.core.typed import Point, Positive, Several
from camsim.scene.charts.chart import Card, Many, chart, counted, grid
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
def checkerboard(
    *,
    side_um: Positive,
    rows: Many = 8,
    cols: Many = 8,
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw a checkerboard; its upper left square is dark.

    side_um    : side of a square
    rows, cols : number of squares down and across, dark and light

    >>> len(checkerboard(side_um=10.0, rows=3, cols=3).shapes)
    5
    """
    counted(checkerboard, "rows", 0.5 * rows * cols)
    card = Card(centre_um, rotate_deg)
    yield from card.behind(cols * side_um, rows * side_um, light)
    for row in range(rows):
        for col in range(row % 2, cols, 2):
            left, top = (col - 0.5 * cols) * side_um, (row - 0.5 * rows) * side_um
            right, bottom = (col + 1 - 0.5 * cols) * side_um, (row + 1 - 0.5 * rows) * side_um
            yield card.cell(left, top, right, bottom, dark)


@chart
def dot_grid(
    *,
    spacing_um: Positive,
    radius_um: Positive,
    rows: Many = 9,
    cols: Many = 9,
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw a grid of round dots, for distortion and lateral colour.

    spacing_um : distance from centre to centre
    radius_um  : radius of a dot
    rows, cols : number of dots down and across

    >>> [dot.centre_um for dot in dot_grid(spacing_um=10.0, radius_um=2.0, rows=1, cols=2).shapes]
    [(-5.0, 0.0), (5.0, 0.0)]
    """
    counted(dot_grid, "rows", rows * cols)
    card = Card(centre_um, rotate_deg)
    yield from card.behind(cols * spacing_um, rows * spacing_um, light)
    for _, _, at_um in grid(rows, cols, spacing_um, spacing_um):
        yield card.disc(radius_um, at_um, dark)


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

    side_um    : of a square
    rows, cols : of squares
    spacing_um : from centre to centre; twice the side when left out
    angles_deg : of the squares along each row, clockwise as displayed, over and over
    dark       : reflectances of the squares down each column, over and over

    >>> [shape.rotate_deg for shape in slanted_edges(side_um=100.0, cols=3, angles_deg=[3, 8]).shapes]
    [3.0, 8.0, 3.0]
    """
    counted(slanted_edges, "rows", rows * cols)
    card = Card(centre_um)
    step_um = 2.0 * side_um if spacing_um is None else spacing_um
    yield from card.behind(cols * step_um, rows * step_um, light)
    for row, col, at_um in grid(rows, cols, step_um, step_um):
        yield card.rectangle(side_um, side_um, at_um, dark[row % len(dark)], angles_deg[col % len(angles_deg)])
