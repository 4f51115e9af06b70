"""The displayed part of a drawing, and its size."""

from __future__ import annotations

import re
from typing import NamedTuple

from camsim.errors import InvalidValueError
from camsim.scene.svg.outline import Matrix, length, numbers
from camsim.scene.svg.xml import Element

_SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
_FIT = r"\s*(?:(none)|x(Min|Mid|Max)Y(Min|Mid|Max))(?:\s+(meet|slice))?\s*"


class View(NamedTuple):
    """The displayed part of a drawing.

    width_px, height_px : size as an editor displays it
    matrix        : map from user units to these px
    whole         : width and height in user units, the reference of percentages
    """

    width_px: float
    height_px: float
    matrix: Matrix
    whole: tuple[float, float]


def view_of(root: Element) -> View:
    """Return the displayed part of a drawing: by its width and height, or else its viewBox."""
    box = numbers(root.attributes["viewBox"]) if "viewBox" in root.attributes else []
    if box and (len(box) != 4 or box[2] <= 0.0 or box[3] <= 0.0):
        raise InvalidValueError(
            f"its viewBox {root.attributes['viewBox'][:40]!r} must be four numbers with a size above 0"
        )
    sizes: list[float | None] = []
    for key in ("width", "height"):
        text = root.attributes.get(key, "100%")
        if text.strip().endswith("%") or text == "auto":
            if not box:
                raise InvalidValueError("has neither width and height nor a viewBox; give it one of them")
            sizes.append(None)
        else:
            sizes.append(length(text))
    if not box:
        width, height = (size or 0.0 for size in sizes)
        box = [0.0, 0.0, width, height]
    width = sizes[0] if sizes[0] is not None else box[2] * (sizes[1] / box[3] if sizes[1] is not None else 1.0)
    height = sizes[1] if sizes[1] is not None else box[3] * (width / box[2])
    if not (width > 0.0 and height > 0.0):
        raise InvalidValueError("its width and height must be above 0")
    said = root.attributes.get("preserveAspectRatio", "").strip() or "xMidYMid"
    fit = re.fullmatch(_FIT, said)
    if fit is None:
        raise InvalidValueError(
            f"its preserveAspectRatio {said[:40]!r} is not understood; give one such as xMinYMid slice"
        )
    stretched, across, down, how = fit.groups()
    x, y = width / box[2], height / box[3]
    if not stretched:
        x = y = max(x, y) if how == "slice" else min(x, y)
    left = _SHARES.get(across, 0.5) * (width - x * box[2]) - x * box[0]
    top = _SHARES.get(down, 0.5) * (height - y * box[3]) - y * box[1]
    return View(width, height, (x, 0.0, 0.0, y, left, top), (box[2], box[3]))
