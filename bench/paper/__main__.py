"""The paper's benchmark: ``python -m bench.paper [--quick] [--peers] [--psf NAME]… [--method NAME]… [-o DIR]``.

Writes results.jsonl (a line as soon as it is known), report.html and the diagram as SVG and PNG. ``make bench`` is the
quick one with other programs, a minute on a quiet machine; ``make bench-all`` everything, half an hour.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from bench.paper.cases import chosen_methods, chosen_psfs
from bench.paper.compare import compared
from bench.paper.peers import installed_peers
from bench.paper.running import Request, run
from bench.report import close
from bench.results import FILE, Results, read_results
from bench.teller import Teller
from camsim.bench.diagram import check_matplotlib
from camsim.errors import CamsimError


def main() -> int:
    """Run what the command line names; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="bench.paper", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="a minute: few systems, few shifts, few laps")
    parser.add_argument("--peers", action="store_true", help="also GalSim and prysm, where installed")
    parser.add_argument("--compare", metavar="OLD.jsonl", help="what got slower or less accurate since that run")
    parser.add_argument("-o", "--output", type=Path, default=Path("out/bench"), metavar="DIR")
    parser.add_argument("--psf", action="append", default=[], metavar="NAME", help="or a pattern: 'airy-f8*'")
    parser.add_argument("--method", action="append", default=[], metavar="NAME")
    parser.add_argument("-q", "--quiet", action="store_true")
    asked = parser.parse_args()
    try:
        _run(asked, asked.psf, asked.method)
    except CamsimError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    return 0


def _run(asked: argparse.Namespace, psfs: Sequence[str], methods: Sequence[str]) -> None:
    check_matplotlib()
    request = Request(
        psfs=tuple(chosen_psfs(psfs, quick=asked.quick)),
        methods=tuple(chosen_methods(methods)),
        quick=asked.quick,
        peers=tuple(installed_peers()) if asked.peers else (),
        paper=not psfs,
    )
    old = None if asked.compare is None else read_results(asked.compare)
    with Results(asked.output / FILE) as results, close(results, "report.html"):
        run(request, results, Teller(displayed=not asked.quiet).tell)
        if old is not None:
            for line in compared(old, results.lines):
                results.add("compared", **line)


if __name__ == "__main__":
    sys.exit(main())
