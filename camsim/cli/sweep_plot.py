"""One column of a manifest against another."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from camsim.errors import InvalidValueError
from camsim.files.atomic import write_whole


def draw_columns(rows: Sequence[dict[str, Any]], x: str, y: str, file: Path) -> None:
    """Draw every file's point, and a line through the medians where a value of ``x`` comes back."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    points = [(row[x], row[y]) for row in rows if row.get(x) is not None and _is_number(row.get(y))]
    if not points:
        raise InvalidValueError(f"no row has both {x!r} and a number in {y!r}", key="--plot")
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    across: list[Any] = [value if _is_number(value) else str(value) for value, _ in points]
    axes.plot(across, [value for _, value in points], "o", ms=4, alpha=0.5, color="#2456a6")
    if all(map(_is_number, across)):
        places = sorted(set(across))
        if len(places) < len(points):
            medians = [
                float(np.median([v for a, (_, v) in zip(across, points, strict=True) if a == at])) for at in places
            ]
            axes.plot(places, medians, "-", lw=1.2, color="#c0392b", label="median")
            axes.legend()
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(alpha=0.3)
    out, suffix = io.BytesIO(), file.suffix.lower()[1:]
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    write_whole(file, out.getvalue())


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
