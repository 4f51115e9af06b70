"""The bar on a terminal: what is at work, and at the first use on a machine what is being compiled."""

import io
import sys
from typing import Any

import pytest

from camsim.cli import progress
from camsim.core.kernels import kernel


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize("displayed", [True, False])
def test_it_says_what_is_compiled(monkeypatch: pytest.MonkeyPatch, displayed: bool) -> None:
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(progress, "_AFTER_S", 0.0)

    # Of no file: what has one is kept, and is not compiled by the next run on this machine.
    scope: dict[str, Any] = {"__name__": __name__}
    exec("def doubled(x):\n    return 2.0 * x\n", scope)
    doubled = kernel()(scope["doubled"])

    with progress.Bar(displayed=displayed) as bar:
        bar.update("light", 0.25)
        assert doubled(1.0) == 2.0
        if bar._bar is not None:
            bar._bar[0].refresh()
        assert doubled(2.0) == 4.0
    said = sys.stderr.getvalue()  # type: ignore[attr-defined]
    assert ("compiling, once on this machine: test_progress.doubled (1)" in " ".join(said.split())) == displayed
    # Whoever compiles after the bar is told nothing.
    assert doubled(3) == 6.0
    assert sys.stderr.getvalue() == said  # type: ignore[attr-defined]
