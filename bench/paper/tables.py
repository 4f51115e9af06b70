"""Tables of a report: rows of the lines' own values, each cell with the value that it shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, TypeAlias

from bench.paper.cases import PAPER_TABLES, PSFS
from bench.paper.findings import contender, true_error
from bench.results import of_kind
from camsim.bench.html import table
from camsim.bench.records import Line

Column: TypeAlias = tuple[str, Callable[[Line], Any]]


POINT_COLUMNS: tuple[Column, ...] = (
    ("system", lambda p: PSFS[p["psf"]].label if p["psf"] in PSFS else p["psf"]),
    ("method", contender),
    ("setting", lambda p: p["label"]),
    ("ran", lambda p: p.get("engine")),
    ("largest error", true_error),
    ("rms error", lambda p: p["error_rms"]),
    ("rms, 16 bits", lambda p: p["error_rms_16bit"]),
    ("own estimate", lambda p: p.get("error_estimate")),
    ("CPU s, 1 thread", lambda p: p.get("one_thread", {}).get("cpu_s")),
    ("wall s, 1 thread", lambda p: p.get("one_thread", {}).get("wall_s")),
    ("CPU s, all threads", lambda p: p.get("all_threads", {}).get("cpu_s")),
    ("wall s, all threads", lambda p: p.get("all_threads", {}).get("wall_s")),
    ("of it set-up and check, CPU s", lambda p: p.get("setup_cpu_s")),
    ("peak MB", lambda p: p.get("peak_mb")),
    ("MB beyond", lambda p: p.get("beyond_mb")),
    ("shifts", lambda p: p.get("shifts")),
    ("laps", lambda p: p.get("one_thread", {}).get("laps")),
)


def point_table(lines: Sequence[Line]) -> str:
    """Return everything that was measured, a row each."""
    points = of_kind(lines, "point")
    return table(
        "Every setting that was measured. Errors are absolute, white being 1; times include set-up and check.",
        [head for head, _ in POINT_COLUMNS],
        [[value(p) for _, value in POINT_COLUMNS] for p in points],
        tall=len(points) > 30,
    )


def _by_method(lines: Sequence[Line], names: Sequence[str], value: Callable[[Line], Any]) -> list[list[Any]]:
    """Return a row per setting and a column per system."""
    rows: dict[str, dict[str, Any]] = {}
    for p in of_kind(lines, "point"):
        if p["psf"] in names and p["program"] == "camsim" and p.get("tolerance") in (None, 1e-6):
            rows.setdefault(p["label"], {})[p["psf"]] = value(p)
    return [[label, *(found.get(name) for name in names)] for label, found in rows.items()]


def paper_tables(lines: Sequence[Line]) -> str:
    """Return the paper's tables I and III (RMSE, rounded to 16 bits and not), II (MTF50), and the times."""
    text, measured = "", {p["psf"] for p in of_kind(lines, "point")}
    for number, words in (("I", "Gaussian patterns, point photosites"), ("III", "Airy patterns, point photosites")):
        names = [name for name in PAPER_TABLES[number] if name in measured]
        if not names:
            continue
        heads = ["method", *(PSFS[n].label.replace("Gaussian, ", "").replace("Airy ", "") for n in names)]
        for key, rounding in (
            ("error_rms_16bit", "images rounded to 16 bits, as in the paper"),
            ("error_rms", "unrounded"),
        ):
            rows = _by_method(lines, names, itemgetter(key))
            text += table(f"Table {number}: RMSE, {words}; {rounding}.", heads, rows)
    two = of_kind(lines, "table2")
    if two:
        columns = list(two[0]["error_percent"])
        rows = [[t["label"], *(t["error_percent"][c] for c in columns), t.get("mean_percent")] for t in two]
        caption = (
            "Table II: mean error of MTF50 in per cent, by camsim measure mtf on 16-bit images, Gaussian patterns of "
            "MTF50 as in the headings (cycles per pixel). Empty: edges on whole pixels that never fall to one half."
        )
        text += table(caption, ["method", *columns, "mean"], rows)
    names = [n for n in ("gaussian-0.25", "airy-f8", "airy-f8-box", "airy-f8-box-olpf") if n in measured]
    rows = _by_method(lines, names, lambda p: p.get("all_threads", {}).get("wall_s"))
    if any(v is not None for row in rows for v in row[1:]):
        text += table(
            "Rendering times: wall seconds of the whole frame, all threads.",
            ["method", *(PSFS[n].label for n in names)],
            rows,
        )
    return text
