"""The 24 patches of a ColorChecker Classic on their black frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from camsim.core.typed import Fraction, Point, Positive
from camsim.scene.charts.chart import Card, chart, grid
from camsim.scene.primitives import Shape
from camsim.spectra import named
from camsim.spectra.curve import Reflectance

_ROWS, _COLS = 4, 6


@chart
def colorchecker(
    *,
    width_um: Positive,
    gap: Fraction = 0.2,
    spectra: Literal["ISO 17321-1", "BabelColor Average"] = "ISO 17321-1",
    marks: bool = True,
    frame: Reflectance = 0.03,
    rotate_deg: float = 0.0,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw the chart upright: dark skin at the upper left, white at the lower left.

    width_um : width of the whole chart, its frame included
    gap      : width of the gaps between patches and of the frame around them, as a fraction of a patch
    spectra  : name of the measurement of the patches (camsim list reflectances)
    marks    : whether white angles stand in the frame's corners, with a bar beside the upper left one
    frame    : reflectance of the frame

    >>> len(colorchecker(width_um=600.0, marks=False).shapes)
    25
    """
    patch = width_um / (_COLS + (_COLS + 1) * gap)
    step, margin = patch * (1.0 + gap), patch * gap
    height_um = _ROWS * step + margin
    card = Card(centre_um, rotate_deg)
    yield card.rectangle(width_um, height_um, (0.0, 0.0), frame)
    names = named.reflectance_names()[: _ROWS * _COLS]
    prefix = "" if spectra == "ISO 17321-1" else f"{spectra}/"
    for name, (_, _, at_um) in zip(names, grid(_ROWS, _COLS, step, step), strict=True):
        yield card.rectangle(patch, patch, at_um, named.reflectance(prefix + name))
    if marks and margin > 0.0:
        white = named.reflectance(f"{prefix}white 9.5")
        right, bottom, thick = 0.5 * width_um, 0.5 * height_um, margin / 3.0
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            inner = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]
            corners = [(x * (right - thick * (a + 0.5)), y * (bottom - thick * (b + 0.5))) for a, b in inner]
            yield card.polygon(corners, white)
        yield card.rectangle(3.0 * thick, thick, (-right + 6.0 * thick, -bottom + thick), white)
