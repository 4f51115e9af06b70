"""The figures of README.md, docs/accuracy.md and this folder's README.md, from the stored run: none is typed.

    make bench-all && cp out/bench/results.jsonl bench/paper/ && python -m bench.paper.pages

Writes docs/bench.png, and what stands between the marks ``<!-- bench … -->`` of the pages.
``--check`` writes nothing and fails where the pages are not what the stored run says.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from bench.paper.cases import PSFS
from bench.paper.figures import work_precision
from bench.paper.findings import PAPERS_PROGRAM, TABLE_PSF, cheapest, contender, seconds, three_digits, true_error
from bench.results import of_kind, read_results
from camsim.bench.diagram import png
from camsim.bench.html import displayed
from camsim.bench.records import Line

ROOT = Path(__file__).parents[2]
STORED = ROOT / "bench" / "paper" / "results.jsonl"
PRINTED = json.loads((ROOT / "bench" / "paper" / "printed.json").read_text(encoding="utf-8"))
OURS = {
    "11x11xUP": "uniform-pixel",
    "11x11xU": "uniform",
    "121xIS": "importance, 121 samples",
    "2025xIS": "importance, 2025 samples",
    "40401xIS": "importance, 40401 samples",
    "NI": "strips",
}
EXACT = "auto 1e-6"
FACTOR = 1.5  # beyond this a ratio is explained, or said not to be
TOLERANCES = (1e-4, 1e-6, 1e-8)
IN_SHORT = (
    "auto 1e-4",
    "auto 1e-6",
    "importance, 2025 samples",
    "GalSim, folding_threshold 0.0002",
    "prysm, oversampling 9",
)


def markdown(heads: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    table = [list(heads)]
    table += [["---"] * len(table[0]), *(list(row) for row in rows)]
    return "\n".join("| " + " | ".join(row) + " |" for row in table)


def duration(value: float | None) -> str:
    if value is None:
        return ""
    return f"{three_digits(1e3 * value)} ms" if value < 1.0 else f"{three_digits(value)} s"


def peers(lines: list[Line], only: Sequence[str] | None = None) -> str:
    """Error, time, memory against other programs on the benchmark, and how much faster ``auto`` gets there.

    only : labels of the rows that are shown; all when left out
    """
    points = [p for p in of_kind(lines, "point") if p["psf"] == TABLE_PSF and "one_thread" in p]
    auto = [p for p in points if contender(p) == "auto"]
    rows = []
    for p in points:
        ours = contender(p) == "auto"
        if ours and p["tolerance"] not in TOLERANCES:
            continue
        sampling = p["method"] == "importance" and p["samples"] == PAPERS_PROGRAM["samples"]
        if (p["program"] == "camsim" and not ours and not sampling) or (only and p["label"] not in only):
            continue
        best = None if ours else cheapest(auto, true_error(p))
        name = f"**camsim**, tolerance {p['label'].split()[-1]}" if ours else p["label"]
        if sampling:
            name = f"the paper's sampling, {p['samples']} samples, run by camsim"
        rows.append(
            [
                name,
                displayed(true_error(p)),
                duration(seconds(p)),
                f"{p['peak_mb']:.0f} MB" if "peak_mb" in p else "",
                f"{three_digits((seconds(p) or 0) / (seconds(best) or 1))} ×" if best else "",
            ]
        )
    heads = (
        "program",
        "largest error",
        "CPU time",
        "peak memory",
        "camsim at no larger an error is faster by",
    )
    return markdown(heads, rows)


def machine(lines: list[Line]) -> str:
    run = lines[0]
    versions = ", ".join(f"{name} {v}" for name, v in run["versions"].items() if name in ("galsim", "prysm", "numba"))
    said = " ".join(line["sentence"] for line in of_kind(lines, "machine"))
    return f"{run['machine']['processor']}, {run['threads']} cores, {run['started'][:10]}, {versions}. {said}"


def accuracy(lines: list[Line]) -> str:
    """Return the diagram and the table of docs/accuracy.md."""
    label = PSFS[TABLE_PSF].label
    return f"![Error against time: {label}](bench.png)\n\n*{label}, 446 × 446 photosites.*\n\n{peers(lines)}"


def words(lines: list[Line]) -> str:
    return "\n".join(f"* {line['sentence']}" for line in of_kind(lines, "finding"))


def paper(lines: list[Line]) -> str:
    """Tables I to III: our entry, after rounding to 16 bits as in the paper, the printed one, and ours over it."""
    return "\n\n".join(
        f"**Table {number}** ({words})\n\n{table}"
        for number, words, table in (
            ("I", "RMSE, Gaussian patterns by their MTF50", _rmse(lines, "table_1_rmse_gaussian", "gaussian-{}")),
            ("II", "mean error of MTF50, %", _table_two(lines)),
            ("III", "RMSE, Airy patterns", _rmse(lines, "table_3_rmse_airy", "airy-{}")),
        )
    )


def _rmse(lines: list[Line], table: str, system: str) -> str:
    """Return a table of RMSE: of a printed column the method that is ours, of a printed row the system."""
    columns, rows = PRINTED[table]["columns"], PRINTED[table]["rows"]
    found = {(p["psf"], p["label"]): p["error_rms_16bit"] for p in of_kind(lines, "point")}
    exact = [[key, displayed(found[system.format(key.replace("/", "")), EXACT])] for key in rows]
    body = []
    for (key, ours), row in zip(exact, rows.values(), strict=True):
        psf = system.format(key.replace("/", ""))
        body.append([key, *(beside(found[psf, OURS[c]], v) for c, v in zip(columns, row, strict=True)), ours])
    return markdown(("", *(f"{c}: {OURS[c]}" for c in columns), EXACT), body)


def _table_two(lines: list[Line]) -> str:
    """Return the table of MTF50: the measurement is ours and theirs, not only the images."""
    printed = PRINTED["table_2_mtf50_error_percent_gaussian"]
    found = {line["label"]: line["error_percent"] for line in of_kind(lines, "table2")}
    body = [
        [
            key,
            *(beside(found[OURS[c]][key], v) for c, v in zip(printed["columns"], row, strict=True)),
            displayed(found["boundary"][key]),
            displayed(found["closed form"][key]),
        ]
        for key, row in printed["rows"].items()
    ]
    return markdown(("", *(f"{c}: {OURS[c]}" for c in printed["columns"]), "boundary", "closed form"), body)


def beside(ours: float | None, theirs: float) -> str:
    """Return our entry, the printed one in brackets, and the ratio; bold where that is beyond the factor.

    >>> beside(0.00479, 0.00304), beside(0.0118, 0.0124), beside(None, 150.0)
    ('0.00479 (0.00304) **1.58**', '0.0118 (0.0124) 0.95', 'none (150)')
    """
    if ours is None:
        return f"none ({displayed(theirs)})"
    ratio = ours / theirs
    words = f"{ratio:.2f}" if ratio >= 0.095 else displayed(float(f"{ratio:.1g}"))
    mark = "" if 1.0 / FACTOR <= ratio <= FACTOR else "**"
    return f"{displayed(ours)} ({displayed(theirs)}) {mark}{words}{mark}"


def times(lines: list[Line]) -> str:
    """The printed rendering times beside ours, of one thread: other machines, years apart."""
    found = {(p["psf"], p["label"]): p["one_thread"]["wall_s"] for p in of_kind(lines, "point") if "one_thread" in p}
    printed, body = PRINTED["rendering_seconds"], []
    for words, psf, entries in (
        ("Gaussian", "gaussian-0.25", printed["gaussian_sd_0.625"]),
        ("Airy f/8", "airy-f8", printed["airy_f8"]),
        ("Airy f/8 + photosite", "airy-f8-box", {"2025xIS": printed["airy_f8_photosite_2025xIS"]}),
        ("Airy f/8 + photosite + OLPF", "airy-f8-box-olpf", {"2025xIS": printed["airy_f8_photosite_olpf_2025xIS"]}),
    ):
        for column, theirs in entries.items():
            body.append([words, OURS[column], duration(found.get((psf, OURS[column]))), duration(theirs)])
        body.append([words, EXACT, duration(found.get((psf, EXACT))), ""])
    return markdown(("system", "method", "ours, one thread", "printed"), body)


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
        ROOT / "README.md": {"readme": peers(lines, IN_SHORT)},
        ROOT / "docs" / "accuracy.md": {"accuracy": accuracy(lines)},
        STORED.with_name("README.md"): {
            "words": words(lines),
            "paper": paper(lines),
            "times": times(lines),
            "machine": machine(lines),
        },
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
    (ROOT / "docs" / "bench.png").write_bytes(png(work_precision(lines, TABLE_PSF)))


if __name__ == "__main__":
    main()
