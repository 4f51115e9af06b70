"""docs/extremes.md from the lines of a run."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Sequence

from bench.results import of_kind
from camsim.bench.records import Line

HEAD = """\
# Stiff and extreme cases

Right to the tolerance, or refused with a reason; never silently wrong. `make extremes` runs all of them on your
machine, exits with 1 when one is wrong, and writes `out/extremes/extremes.html`; this page was made by
`python -m bench.extremes --page docs/extremes.md`. The lists are `bench/extremes/rendering_cases.py` and
`sensor_cases.py`; `tests/extremes/` runs what is quick of them. Lengths are in pitches; errors are relative to full
scale, those of the sensor in the case's own unit (codes, electrons, counts).
*Truth*: quadrature is the boundary integral by plain Gauss rules, without tables, far forms or transforms
(`tests/truth/quadrature.py`); rays adds up the light beyond a straight edge angle by angle; fourier is the other
engine, asked for 1e-11; identity is what must come out whatever the optics do; a sensor's truth is arithmetic on paper.
Times are of a rendering after the first, on two cores.
"""


def markdown(lines: Sequence[Line]) -> str:
    """Return the page."""
    return "\n".join(_lines(of_kind(lines, "extreme"))) + "\n"


def _lines(cases: Sequence[Line]) -> Iterator[str]:
    yield HEAD
    yield "| case | input | asked | error | truth | seconds | verdict |"
    yield "|---|---|---|---|---|---|---|"
    for case in cases:
        if case["verdict"] != "refused":
            reached = f"{case['reached']:.1e}" if "reached" in case else "–"
            asked = f"{case['asked']:g}" if "asked" in case else "–"
            figures = f"{asked} | {reached} | {case['truth']} | {case['seconds']:.3f}"
            yield f"| {case['name']} | {case['input']} | {figures} | {case['verdict']} |"
    yield "\n## Refused\n\n| case | input | what is said |\n|---|---|---|"
    for case in cases:
        if case["verdict"] == "refused":
            yield f"| {case['name']} | {case['input']} | {case['truth']} |".replace("||", "| |")
    wrong = [case["name"] for case in cases if case["verdict"] == "wrong"]
    yield f"\n{len(cases)} cases on {platform.machine()}; wrong: {', '.join(wrong) or 'none'}."
