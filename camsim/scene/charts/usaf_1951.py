"""The USAF 1951 resolution chart: three-bar elements by group and number."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Ge, Le, MinLen

from camsim.core.typed import Point, Several
from camsim.scene.charts.chart import Card, Place, chart
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance, Spectrum

# In widths of a bar: three bars with their gaps are a square, an element two of them.
_SQUARE, _GAP = 5.0, 2.0
_ELEMENT = 2.0 * _SQUARE + _GAP
_SIZES = tuple(2.0 ** (-index / 6.0) for index in range(6))

# In widths of the coarsest bar of two groups: where the columns end, and the space between them for the next two.
_LEFT = _ELEMENT * _SIZES[1]
_RIGHT = 0.5 * _ELEMENT
_WIDTH = (_LEFT + _RIGHT + 2.0 * _GAP) / 0.75
_HEIGHT = (_SQUARE + _GAP) * sum(_SIZES[1:]) - _GAP * _SIZES[5]
_INNER_AT = (0.5 * (_LEFT - _RIGHT), -0.5 * (_SQUARE + _GAP))


@chart
def usaf_1951(
    *,
    groups: Annotated[Several[Annotated[int, Ge(-10), Le(20)]], MinLen(1)] = (0, 1),
    labels: bool = True,
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw groups of the USAF 1951 resolution chart (MIL-STD-150A).

    Element e of group g has 2^(g + (e − 1)/6) line pairs per mm: three bars, each five times as long as wide, with gaps
    as wide as the bars, upright and beside that level. Two groups stand beside each other, the finer ones inside, as
    on the chart; distances between elements are camsim's own.

    groups : numbers of the groups; on the sensor, group 0 begins with 1 line pair per mm
    labels : whether the numbers of groups and elements stand beside them

    >>> element = usaf_1951(groups=[4]).shapes[0]
    >>> element.width_um, element.height_um
    (31.25, 156.25)
    """
    card = Card(centre_um, rotate_deg)
    ordered = sorted(set(groups))
    outer = ordered[0] - ordered[0] % 2
    margin = 2.0 * _SQUARE
    yield from card.behind((_WIDTH + margin) * bar_um(outer), (_HEIGHT + margin) * bar_um(outer), light)
    for group in ordered:
        for element in range(1, 7):
            yield from _element(card, bar_um(group, element), _place_um(group, element, outer), dark)
        if labels:
            yield from _labels(card, group, outer, dark)


def bar_um(group: int, element: int = 1) -> float:
    """Return the width of an element's bars, half a line pair, in µm.

    >>> bar_um(0), bar_um(2, 1)
    (500.0, 125.0)
    """
    bar: float = 500.0 / 2.0 ** (group + (element - 1) / 6.0)
    return bar


def _element(card: Card, bar: float, at_um: Place, dark: Spectrum) -> Iterator[Shape]:
    """Draw three upright bars and, to their right, three level ones."""
    length, offset = _SQUARE * bar, 0.5 * (_SQUARE + _GAP) * bar
    for step in (-2.0 * bar, 0.0, 2.0 * bar):
        yield card.rectangle(bar, length, (at_um[0] - offset + step, at_um[1]), dark)
    for step in (-2.0 * bar, 0.0, 2.0 * bar):
        yield card.rectangle(length, bar, (at_um[0] + offset, at_um[1] + step), dark)


def _labels(card: Card, group: int, outer: int, dark: Spectrum) -> Iterator[Shape]:
    """Write each element's number at its outer side, and the group's above its column."""
    odd = (group - outer) % 2 == 1
    for element in range(1, 7):
        bar, (x, y) = bar_um(group, element), _place_um(group, element, outer)
        away = 0.5 * _ELEMENT * bar + bar
        yield card.text(str(element), 4.0 * bar, (x + away if odd else x - away, y), "left" if odd else "right", dark)
    top = 1 if odd else 2
    bar, (x, y) = bar_um(group, top), _place_um(group, top, outer)
    yield card.text(str(group), 4.0 * bar, (x, y - _SQUARE * bar), "centre", dark)


def _place_um(group: int, element: int, outer: int) -> Place:
    """Return the centre of an element: of even groups the first is at the lower right, others down the left side."""
    first, x, y = outer, 0.0, 0.0
    while first + 2 <= group:
        x, y = x + _INNER_AT[0] * bar_um(first), y + _INNER_AT[1] * bar_um(first)
        first += 2
    unit, bar = bar_um(first), bar_um(group, element)
    right, bottom = 0.5 * _WIDTH * unit, 0.5 * _HEIGHT * unit
    if group == first and element == 1:
        return x + right - 0.5 * _ELEMENT * bar, y + bottom - 0.5 * _SQUARE * bar
    above = _SIZES[1 if group == first else 0 : element - 1]
    down = math.fsum(above) * (_SQUARE + _GAP) * bar_um(group) + 0.5 * _SQUARE * bar - bottom
    across = 0.5 * _ELEMENT * bar - right
    return (x + across, y + down) if group == first else (x - across, y + down)
