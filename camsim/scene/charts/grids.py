"""What repeats along both axes: the checkerboard and the grid of dots."""

from __future__ import annotations

from collections.abc import Iterator

from camsim.core.typed import Point, Positive
from camsim.scene.charts.chart import Card, Many, chart, counted
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
    if light is not None:
        yield card.rectangle(cols * side_um, rows * side_um, (0.0, 0.0), light)
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
    if light is not None:
        yield card.rectangle(cols * spacing_um, rows * spacing_um, (0.0, 0.0), light)
    for row in range(rows):
        for col in range(cols):
            at_um = ((col - 0.5 * (cols - 1)) * spacing_um, (row - 0.5 * (rows - 1)) * spacing_um)
            yield card.disc(radius_um, at_um, dark)
