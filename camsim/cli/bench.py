"""``camsim bench``: measure, tell how far it is, write lines, figures and a page."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from camsim.errors import OutputError

if TYPE_CHECKING:
    from camsim.bench.results import Line, Results

_EVERY_S = 2.0


def bench(
    quick: Annotated[bool, typer.Option("--quick", help="A minute: few systems, few shifts, few laps.")] = False,
    peers: Annotated[bool, typer.Option("--peers", help="Also run GalSim and prysm, where installed.")] = False,
    extremes: Annotated[
        bool, typer.Option("--extremes", help="Instead: stiff and extreme cases, exit code 1 when one is wrong.")
    ] = False,
    scaling: Annotated[
        bool, typer.Option("--scaling", help="Instead: time and memory against photosites, edges, wavelengths, ….")
    ] = False,
    compare: Annotated[
        str | None,
        typer.Option("--compare", metavar="OLD.jsonl", help="Say what got slower or less accurate since that run."),
    ] = None,
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="DIR", help="Folder for results.jsonl, the report and the figures.")
    ] = "bench-results",
    psfs: Annotated[
        list[str] | None,
        typer.Option("--psf", metavar="NAME", help="One system, or a pattern such as 'airy-f8*'; repeatable."),
    ] = None,
    methods: Annotated[
        list[str] | None, typer.Option("--method", metavar="NAME", help="One method; repeatable. All when left out.")
    ] = None,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print no progress.")] = False,
) -> None:
    """Measure error against run time, here and now: every method, and the programs people would use instead.

    Writes results.jsonl (a line as soon as it is known), report.html and the diagram as SVG and PNG.
    """
    from camsim.bench.cases import chosen_methods, chosen_psfs
    from camsim.bench.compare import compared
    from camsim.bench.diagram import check_matplotlib
    from camsim.bench.peers import installed_peers
    from camsim.bench.results import FILE, Results, read_results
    from camsim.bench.running import Request, run

    check_matplotlib()
    teller = _Teller(shown=not quiet)
    if extremes or scaling:
        _run_lists(Path(output), teller, extremes=extremes, scaling=scaling, quick=quick)
        return
    request = Request(
        psfs=tuple(chosen_psfs(psfs or (), quick=quick)),
        methods=tuple(chosen_methods(methods or ())),
        quick=quick,
        peers=tuple(installed_peers()) if peers else (),
        paper=not psfs,
    )
    old = None if compare is None else read_results(compare)
    folder = Path(output)
    _check_folder(folder)
    with Results(folder / FILE) as results:
        try:
            run(request, results, teller.tell)
            if old is not None:
                for line in compared(old, results.lines):
                    results.add("compared", **line)
        except KeyboardInterrupt:
            _report(results, "interrupted; what was measured is in")
            raise
    _report(results, "written:")


def _run_lists(folder: Path, teller: _Teller, *, extremes: bool, scaling: bool, quick: bool) -> None:
    """Run the extremes, the scaling or both, each into files of its own; exit code 1 when an extreme is wrong."""
    from camsim.bench.lists import run_extremes, start
    from camsim.bench.results import Results
    from camsim.bench.scaling import run_scaling

    _check_folder(folder)
    failed = 0
    for name in ("extremes",) * extremes + ("scaling",) * scaling:
        with Results(folder / f"{name}.jsonl") as results:
            start(results, quick=quick)
            try:
                if name == "extremes":
                    failed = run_extremes(results, teller.tell)
                else:
                    run_scaling(results, teller.tell, quick=quick)
            except KeyboardInterrupt:
                _report(results, "interrupted; what was measured is in", f"{name}.html")
                raise
        _report(results, "written:", f"{name}.html")
    if failed:
        raise typer.Exit(1)


def _check_folder(folder: Path) -> None:
    """Refuse a folder that cannot be written to, before the long work."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(
            f"cannot write into {str(folder)!r}: {error.strerror or error}; choose a folder with -o"
        ) from None


def _report(results: Results, words: str, page: str = "report.html") -> None:
    from camsim.bench.report import write_report

    for line in _sentences(results.lines):
        print(line)
    files = [results.path, *write_report(results.lines, results.path.parent, page)]
    print(f"{words} {', '.join(os.path.relpath(file) for file in files)}")


def _sentences(lines: Sequence[Line]) -> list[str]:
    """Return what the run says in words, and the table of extremes."""
    from camsim.bench.results import of_kind

    said = [str(line["sentence"]) for line in of_kind(lines, "machine", "finding", "compared")]
    extremes = of_kind(lines, "extreme")
    if extremes:
        width = max(len(line["name"]) for line in extremes)
        said += [
            f"{line['name']:{width}}  asked {line.get('asked', '–'):<8}  reached {line.get('reached', '–'):<10}  "
            f"{line['seconds']:>8.3g} s  {line['verdict']}"
            for line in extremes
        ]
    return said


class _Teller:
    """Says on stderr how far the work is and how long it may yet take: every two seconds, on one line if it can."""

    def __init__(self, *, shown: bool) -> None:
        self._shown, self._began, self._last = shown, time.perf_counter(), -_EVERY_S
        self._over = "\r\x1b[K" if sys.stderr.isatty() else ""

    def tell(self, fraction: float, words: str) -> None:
        now = time.perf_counter() - self._began
        if not self._shown or (now - self._last < _EVERY_S and fraction < 1.0):
            return
        self._last = now
        left = f", about {_duration(now * (1.0 - fraction) / fraction)} left" if 0.0 < fraction < 1.0 else ""
        end = "\n" if not self._over or fraction >= 1.0 else ""
        print(f"{self._over}{100.0 * fraction:3.0f} %  {words}{left}", file=sys.stderr, end=end, flush=True)


def _duration(seconds: float) -> str:
    """Return a duration in words.

    >>> _duration(42.4), _duration(160.0)
    ('42 s', '3 min')
    """
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
