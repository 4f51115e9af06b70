"""Every stiff and extreme case: ``python -m bench.extremes [-o DIR]``. Takes some minutes.

Writes extremes.jsonl and extremes.html; exit code 1 when a case is wrong.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from bench.extremes.running import run_extremes
from bench.report import close
from bench.results import Results
from bench.teller import Teller


def main() -> None:
    """Run what the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("out/extremes"), metavar="DIR")
    asked = parser.parse_args()
    with Results(asked.output / "extremes.jsonl") as results:
        results.start(quick=False)
        failed = 0
        with close(results, "extremes.html"):
            failed = run_extremes(results, Teller().tell)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
