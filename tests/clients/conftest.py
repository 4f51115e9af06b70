"""Prints the table of programs and files after the tests that filled it."""

import pytest
import table


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if not table.CELLS:
        return
    from raw_programs import PROGRAMS

    broken = {report.nodeid for key in ("failed", "error") for report in terminalreporter.stats.get(key, [])}
    skipped = len(terminalreporter.stats.get("skipped", []))
    terminalreporter.section("programs from elsewhere")
    for program in PROGRAMS:
        terminalreporter.write_line(f"{program.name} {program.version()}")
    for line in table.lines():
        terminalreporter.write_line(line)
    good = [p for p in PROGRAMS if not any(f"[{p.name}" in name or f"-{p.name}]" in name for name in broken)]
    others = [name for name in broken if not any(p.name in name for p in PROGRAMS)]
    tail = "plus exiftool" if not others else f"and {len(others)} other failures"
    left_out = f"{skipped} skipped" if skipped else "zero skipped"
    terminalreporter.write_line(f"clients {len(good)}/{len(PROGRAMS)} {tail}, {left_out}")
