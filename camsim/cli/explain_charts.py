"""What ``camsim explain`` tells of charts and drawings: what each became, and how much the window does not see."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camsim.exposing import Capture
    from camsim.rendering.engine import Decision
    from camsim.rendering.grid import Grid
    from camsim.scene import Chart, Drawing


def chart_decisions(capture: Capture) -> Iterator[Decision]:
    """Tell of every chart of a scene, also of those in groups."""
    from camsim.rendering.engine import Decision

    for chart, alone in _charts(capture.scene.shapes, alone=True):
        kinds = Counter(type(shape).__name__ for shape in _leaves(chart.shapes))
        told = ", ".join(f"{count} {_word(kind, count)}" for kind, count in kinds.most_common())
        sides, curves, unseen, all_of = _counted(chart, capture.grid)
        outside = f"; {unseen} of {all_of} lie outside the window" if alone and unseen else ""
        yield Decision(
            topic=chart.name, decision=f"{sides} sides, {curves} curves", reason=f"{told or 'nothing'}{outside}"
        )


def _charts(shapes: Iterable[Any], *, alone: bool) -> Iterator[tuple[Chart | Drawing, bool]]:
    """Yield charts, and whether they lie where they say: in no group that moves them."""
    from camsim.scene import Chart, Drawing

    for shape in shapes:
        if isinstance(shape, Chart | Drawing):
            yield shape, alone
        else:
            yield from _charts(getattr(shape, "shapes", ()), alone=False)


def _leaves(shapes: Iterable[Any]) -> Iterator[Any]:
    for shape in shapes:
        inner = getattr(shape, "shapes", None)
        if inner is None:
            yield shape
        else:
            yield from _leaves(inner)


def _counted(chart: Chart | Drawing, grid: Grid) -> tuple[int, int, int, int]:
    """Return straight sides, curves, what of all that is painted lies outside the window, and how much is painted."""
    from camsim.scene.curves import STRAIGHT

    x, y = (grid.pitch_um * (first - 0.5) for first in grid.first_centre)
    right, bottom = x + grid.pitch_um * grid.cols, y + grid.pitch_um * grid.rows
    sides = curves = unseen = painted = 0
    for primitive in chart.primitives():
        painted += 1
        seen = False
        for fill in primitive.layers[0]:
            straight = int((fill.curves.kind == STRAIGHT).sum())
            sides, curves = sides + straight, curves + len(fill.curves.kind) - straight
            low_x, low_y = fill.curves.boxes[:, :2].min(axis=0, initial=float("inf"))
            high_x, high_y = fill.curves.boxes[:, 2:].max(axis=0, initial=float("-inf"))
            seen = seen or (low_x < right and high_x > x and low_y < bottom and high_y > y)
        unseen += not seen
    return sides, curves, unseen, painted


def _word(kind: str, count: int) -> str:
    """Return what to call so many shapes of a class.

    >>> _word("RegularPolygon", 2), _word("Text", 1), _word("Star", 2)
    ('regular polygons', 'text', 'stars')
    """
    words = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in kind).strip()
    return words if count == 1 else f"{words}s"
