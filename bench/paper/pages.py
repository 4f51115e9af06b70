"""The README's and docs/bench.md's figures from the stored run: nothing in them is typed.

    make bench-all && cp out/bench/results.jsonl bench/paper/ && python -m bench.paper.pages

Writes docs/bench.svg and docs/bench.png, and what stands between the marks ``<!-- bench … -->`` in both pages.
``--check`` writes nothing and fails where the pages are not what the stored run says.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterable
from pathlib import Path

from bench.paper.cases import PAPER_TABLES, PSFS
from bench.paper.figures import work_precision
from bench.paper.findings import PAPERS_PROGRAM, TABLE_PSF, cheapest, contender, seconds, three_digits, true_error
from bench.results import of_kind, read_results
from camsim.bench.diagram import png, svg
from camsim.bench.html import shown
from camsim.bench.records import Line

ROOT = Path(__file__).parents[2]
STORED = ROOT / "bench" / "paper" / "results.jsonl"
TOLERANCES = (1e-4, 1e-6, 1e-8)


def markdown(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    table = [list(heads)]
    table += [["---"] * len(table[0]), *(list(row) for row in rows)]
    return "\n".join("| " + " | ".join(row) + " |" for row in table)


def duration(value: float | None) -> str:
    if value is None:
        return ""
    return f"{three_digits(1e3 * value)} ms" if value < 1.0 else f"{three_digits(value)} s"


def peers(lines: list[Line]) -> str:
    """Error, time, memory against other programs on the benchmark, and how much faster ``auto`` gets there."""
    points = [p for p in of_kind(lines, "point") if p["psf"] == TABLE_PSF and "one_thread" in p]
    auto = [p for p in points if contender(p) == "auto"]
    rows = []
    for p in points:
        ours = contender(p) == "auto"
        if ours and p["tolerance"] not in TOLERANCES:
            continue
        sampling = p["method"] == "importance" and p["samples"] == PAPERS_PROGRAM["samples"]
        if p["program"] == "camsim" and not ours and not sampling:
            continue
        best = None if ours else cheapest(auto, true_error(p))
        name = f"**camsim**, tolerance {p['label'].split()[-1]}" if ours else p["label"]
        if sampling:
            name = f"the paper's sampling, {p['samples']} samples, run by camsim"
        rows.append(
            [
                name,
                shown(true_error(p)),
                duration(seconds(p)),
                duration(p.get("all_threads", {}).get("wall_s", p["one_thread"]["wall_s"])),
                f"{p['peak_mb']:.0f} MB" if "peak_mb" in p else "",
                f"{three_digits((seconds(p) or 0) / (seconds(best) or 1))} ×" if best else "",
            ]
        )
    paper = PAPERS_PROGRAM
    rows.append(
        [
            f"the paper's own program, {paper['samples']} samples (another day)",
            shown(paper["error_max"]),
            "",
            duration(paper["wall_s"]),
            f"{paper['peak_mb']:.0f} MB",
            "",
        ]
    )
    heads = (
        "program",
        "largest error",
        "CPU time",
        "wall time",
        "peak memory",
        "camsim, no larger an error, is faster by",
    )
    return markdown(heads, rows)


def machine(lines: list[Line]) -> str:
    run = lines[0]
    versions = ", ".join(f"{name} {v}" for name, v in run["versions"].items() if name in ("galsim", "prysm", "numba"))
    said = " ".join(line["sentence"] for line in of_kind(lines, "machine"))
    return f"{run['machine']['processor']}, {run['threads']} cores, {run['started'][:10]}, {versions}. {said}"


def readme(lines: list[Line]) -> str:
    label = PSFS[TABLE_PSF].label
    return f"""![Error against time: {label}](docs/bench.png)

{peers(lines)}

*{label}, 446 × 446 photosites; set-up and check included. {machine(lines)}*

Made by `make bench-all` (on your machine too) and `python -m bench.paper.pages`; all that it measures:
[docs/bench.md](docs/bench.md)."""


def words(lines: list[Line]) -> str:
    return "\n".join(f"* {line['sentence']}" for line in of_kind(lines, "finding"))


def paper(lines: list[Line]) -> str:
    """Tables I to III as far as they were measured, after rounding to 16 bits and (in brackets) unrounded."""
    parts = {}
    for number, names in PAPER_TABLES.items():
        rows: dict[str, dict[str, str]] = {}
        for p in of_kind(lines, "point"):
            if p["psf"] in names and p["program"] == "camsim" and p.get("tolerance") in (None, 1e-6):
                entry = f"{shown(p['error_rms_16bit'])} ({shown(p['error_rms'])})"
                rows.setdefault(p["label"], {})[p["psf"]] = entry
        there = [n for n in names if any(n in row for row in rows.values())]
        heads = [PSFS[n].label.replace("Gaussian, MTF50 ", "").replace(" c/px", "").replace("Airy ", "") for n in there]
        if there:
            body = [[label, *(row.get(n, "") for n in there)] for label, row in rows.items()]
            parts[number] = markdown(("RMSE", *heads), body)
    two = of_kind(lines, "table2")
    if two:
        columns = list(two[0]["error_percent"])
        body = [[t["label"], *(number_or_none(t["error_percent"][c]) for c in columns)] for t in two]
        parts["II"] = markdown(("mean error of MTF50, %", *columns), body)
    return "\n\n".join(f"**Table {number}**\n\n{parts[number]}" for number in sorted(parts))


def number_or_none(value: float | None) -> str:
    return "none" if value is None else shown(value)


def filled(text: str, parts: dict[str, str]) -> str:
    """Put each part between its marks."""
    for name, part in parts.items():
        mark = re.compile(rf"(<!-- bench {name} -->\n).*?(\n<!-- /bench {name} -->)", re.DOTALL)
        text, count = mark.subn(lambda found, part=part: found[1] + part + found[2], text)
        if count != 1:
            raise SystemExit(f"{count} places for {name!r}")
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    lines = read_results(STORED)
    pages = {
        ROOT / "README.md": {"readme": readme(lines)},
        ROOT / "docs" / "bench.md": {"words": words(lines), "paper": paper(lines), "machine": machine(lines)},
    }
    stale = []
    for path, parts in pages.items():
        text = path.read_text(encoding="utf-8")
        new = filled(text, parts)
        if new != text:
            stale.append(path.name)
            if not check:
                path.write_text(new, encoding="utf-8")
    if check:
        if stale:
            sys.exit(f"not what {STORED.name} says: {', '.join(stale)}; run python -m bench.paper.pages")
        return
    figure = work_precision(lines, TABLE_PSF)
    (ROOT / "docs" / "bench.svg").write_text(svg(figure, "bench"), encoding="utf-8")
    (ROOT / "docs" / "bench.png").write_bytes(png(figure))


if __name__ == "__main__":
    main()
