"""One column of a manifest against another."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from camsim.errors import InvalidValueError
from camsim.files.atomic import write_whole

_MOST_NAMED = 12
_UNITS = {
    "cycles_per_pixel": "cycles/pixel", "lp_per_mm": "lp/mm", "electrons_per_dn": "e⁻/DN", "e_per_s": "e⁻/s",
    "um": "µm", "nm": "nm", "mm": "mm", "deg": "degrees", "pitches": "pitches", "pixel": "pixels", "waves": "waves",
    "e": "e⁻", "dn": "DN", "s": "s", "lux": "lux", "w_per_m2": "W/m²", "cd_per_m2": "cd/m²", "k": "K", "c": "°C",
    "bytes": "bytes", "seconds": "s",
}  # fmt: skip
"""Units by the ending of a key's name or, before a channel's, of a column's."""


def draw_columns(rows: Sequence[dict[str, Any]], x: str, y: str, file: Path, *, by: Sequence[str] = ()) -> None:
    """Draw every file's point, and for each combination of ``by`` a line through the medians.

    by : columns of varying keys; those drawn as axes, or constant, are omitted
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    good = [row for row in rows if row.get(x) is not None and _is_number(row.get(y))]
    if not good:
        raise InvalidValueError(f"no row has both {x!r} and a number in {y!r}", key="--plot")
    numbers = all(_is_number(row[x]) for row in good)
    others = [name for name in by if name not in (x, y) and not x.startswith(f"{name}_")]
    others = [name for name in others if len({_word(row.get(name)) for row in good}) > 1]
    groups: dict[str, dict[Any, list[float]]] = {}
    for row in good:
        label = ", ".join(f"{name} {_word(row.get(name))}" for name in others)
        across = row[x] if numbers else _word(row[x])
        groups.setdefault(label, {}).setdefault(across, []).append(row[y])
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    axes = figure.subplots()
    for label, at in groups.items():
        places = sorted(at) if numbers else list(at)
        (line,) = axes.plot(places, [float(np.median(at[place])) for place in places], "-" if numbers else "", lw=1.2)
        if len(groups) <= _MOST_NAMED:
            line.set_label(label or "median")
        pairs = [(place, value) for place in places for value in at[place]]
        axes.plot(*zip(*pairs, strict=True), "o", ms=4, alpha=0.5, color=line.get_color())
    if len(groups) <= _MOST_NAMED and (others or any(len(one) > 1 for at in groups.values() for one in at.values())):
        axes.legend(fontsize="small")
    axes.set_xlabel(_with_unit(x))
    axes.set_ylabel(_with_unit(y))
    axes.grid(alpha=0.3)
    out, suffix = io.BytesIO(), file.suffix.lower()[1:]
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    write_whole(file, out.getvalue())


def _with_unit(column: str) -> str:
    """Return a column's name with its unit, which is part of its name; dimensionless ones have none.

    >>> _with_unit("sensor_frame_pitch_um"), _with_unit("mtf50_lp_per_mm_G1"), _with_unit("snr_G")
    ('sensor_frame_pitch_um, µm', 'mtf50_lp_per_mm_G1, lp/mm', 'snr_G')
    """
    words = re.sub(r"_(theory|error)\b", "", column.replace(".", "_")).split("_")
    if len(words) > 1 and words[-1][:1].isupper():  # a channel's
        words.pop()
    ends = ("_".join(words[k:]) for k in range(len(words)))  # the longest first: e⁻/s must not match s
    unit = next((_UNITS[end] for end in ends if end in _UNITS), "")
    return f"{column}, {unit}" if unit else column


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _word(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, dict):
        return " ".join(_word(one) for one in value.values())
    return f"{value:g}" if _is_number(value) else str(value)
