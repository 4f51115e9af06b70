"""The page of stiff and extreme cases: ``python -m bench.extremes_page > docs/extremes.md``. Takes some minutes."""

from __future__ import annotations

import platform
import sys

from camsim.bench import extremes, sensor_extremes
from camsim.bench.extremes import ExtremeCase, Outcome

HEAD = """\
# Stiff and extreme cases

Right to the tolerance, or refused with a reason; never silently wrong. Made by `python -m bench.extremes_page`; the
lists are `camsim/bench/extreme_cases.py` and `sensor_extremes.py`, `tests/extremes/` runs what is quick of them, and
`camsim bench --extremes` all of it on your machine. Lengths are in pitches; errors are relative to full scale, those of
the sensor in the case's own unit (codes, electrons, counts).
*Truth*: quadrature is the boundary integral by plain Gauss rules, without tables, far forms or transforms; rays adds up
the light beyond a straight edge angle by angle;
fourier is the other engine, asked for 1e-11; identity is what must come out whatever the
optics do; a sensor's truth is arithmetic on paper. Times are of a rendering after the first, on two cores.
"""


def main() -> None:
    """Run every case and print the page."""
    print(HEAD)
    print("| case | input | asked | error | truth | seconds | verdict |")
    print("|---|---|---|---|---|---|---|")
    told = []
    for case in (*extremes.cases(), *sensor_extremes.cases()):
        outcome = case.run()
        print(f"{case.name}: {outcome.verdict}", file=sys.stderr)
        told.append((case, outcome))
    for case, outcome in told:
        if outcome.verdict != "refused":
            print(_row(case, outcome))
    print("\n## Refused\n\n| case | input | what is said |\n|---|---|---|")
    for case, outcome in told:
        if outcome.verdict == "refused":
            print(f"| {case.name} | {case.input} | {outcome.truth} |".replace("||", "| |"))
    wrong = [case.name for case, outcome in told if outcome.verdict == "wrong"]
    print(f"\n{len(told)} cases on {platform.machine()}; wrong: {', '.join(wrong) or 'none'}.")


def _row(case: ExtremeCase, outcome: Outcome) -> str:
    reached = "–" if outcome.reached is None else f"{outcome.reached:.1e}"
    return (
        f"| {case.name} | {case.input} | {outcome.asked:g} | {reached} | {outcome.truth} | {outcome.seconds:.3f} "
        f"| {outcome.verdict} |"
    )


if __name__ == "__main__":
    main()
