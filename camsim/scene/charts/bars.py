"""Bars: line pairs by frequency."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated

from annotated_types import MinLen

from camsim.core.typed import Point, Positive, Several
from camsim.scene.charts.chart import Card, Many, chart, counted, periods
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
def bars(
    *,
    lp_per_mm: Annotated[Several[Positive], MinLen(1)] | None = None,
    periods_um: Annotated[Several[Positive], MinLen(1)] | None = None,
    pairs: Many = 5,
    length_um: Positive | None = None,
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw sets of upright bars side by side, one set for each frequency, in the order given.

    lp_per_mm  : line pairs per mm on the sensor, one number for each set
    periods_um : instead: for each set the length of a line pair, a dark bar and the gap beside it
    pairs      : number of dark bars of a set
    length_um  : length of the bars; five periods of the coarsest set when left out

    >>> [bar.width_um for bar in bars(lp_per_mm=[50.0, 100.0], pairs=2).shapes]
    [10.0, 10.0, 5.0, 5.0]
    """
    sets_um = periods(bars, lp_per_mm, periods_um)
    counted(bars, "pairs", pairs * len(sets_um))
    length = 5.0 * max(sets_um) if length_um is None else length_um
    # A set consists of its bars, the gaps between them, and a gap of two periods to the next set.
    widths = [(pairs - 0.5) * period for period in sets_um]
    gaps = [2.0 * max(pair) for pair in pairwise(sets_um)]
    whole = sum(widths) + sum(gaps)
    card = Card(centre_um, rotate_deg)
    margin = 4.0 * max(sets_um)
    yield from card.behind(whole + margin, length + margin, light)
    left = -0.5 * whole
    for period, width, gap in zip(sets_um, widths, [*gaps, 0.0], strict=True):
        for index in range(pairs):
            yield card.rectangle(0.5 * period, length, (left + (index + 0.25) * period, 0.0), dark)
        left += width + gap
