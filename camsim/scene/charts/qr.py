"""A QR code, to test the whole path from a scene to a reader."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Annotated, Literal

from annotated_types import MinLen

from camsim.core.typed import Point, Positive
from camsim.scene.charts.chart import Card, chart, refused
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
def qr(
    *,
    text: Annotated[str, MinLen(1)],
    width_um: Positive,
    level: Literal["L", "M", "Q", "H"] = "M",
    rotate_deg: float = 0.0,
    dark: Reflectance = 0.05,
    light: Reflectance = 0.9,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw a QR code (ISO/IEC 18004) with its quiet zone of four modules.

    text     : text of the code; camsim chooses the smallest version that holds it
    width_um : width of the whole code with its quiet zone
    level    : level of error correction: 7 % (L), 15 % (M), 25 % (Q) or 30 % (H) of the code may be unreadable

    >>> code = qr(text="camsim", width_um=290.0)
    >>> code.shapes[0].width_um / 29  # 21 modules and a quiet zone: a module is 10 µm
    10.0
    """
    import segno

    try:
        # segno's automatic increase of the level would make the drawing depend on segno's version.
        code = segno.make_qr(text, error=level.lower(), boost_error=False)
    except (ValueError, segno.DataOverflowError):
        message = f"{len(text)} letters are too many for a QR code of level {level}; shorten them or take level L"
        raise refused(qr, "text", message) from None
    modules = [list(row) for row in code.matrix_iter(border=4)]
    lines_um = [width_um * (index / len(modules) - 0.5) for index in range(len(modules) + 1)]
    card = Card(centre_um, rotate_deg)
    yield card.rectangle(width_um, width_um, (0.0, 0.0), light)
    for row, line in enumerate(modules):
        for module, run in itertools.groupby(enumerate(line), lambda place: place[1]):
            cols = [col for col, _ in run]
            if module:
                yield card.cell(lines_um[cols[0]], lines_um[row], lines_um[cols[-1] + 1], lines_um[row + 1], dark)
