"""What every page of a bench is held to: its numbers are its lines' own."""

import re

from camsim.bench.html import displayed


def assert_numbers_are_from(text, lines):
    """Cells carry the value they show; that value is in the lines, and sentences are lines' own."""
    values = set(numbers_of(lines))
    cells = re.findall(r'<td data-v="([^"]+)">([^<]+)</td>', text)
    assert len(cells) > 10
    for value, printed in cells:
        assert float(value) in values, value
        decimals = len(printed.partition(".")[2])
        assert printed in (displayed(float(value)), f"{round(float(value), decimals) + 0.0:.{decimals}f}")
    assert not re.findall(r"<td[^>]*>\s*[-+]?\d[\d.e-]*\s*</td>", re.sub(r"<td data-v=[^<]+</td>", "", text))
    said = "\n".join(line["sentence"] for line in lines if "sentence" in line)
    for item in re.findall(r"<li>([^<]+)</li>", text):
        assert item.replace("&#x27;", "'") in said


def numbers_of(value):
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from numbers_of(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)
