"""A progress bar on stderr for long work."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING

from camsim.core.words import duration, percent

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

_AFTER_S = 0.7
_LINE_EVERY_S = 30.0
"""Between lines in a log file."""


class Bar:
    """A bar that is not shown for short work and disappears when done; in a log file, a line every half minute.

    At the first use on a machine it names the kernel being compiled, and its number.
    compiles : False for work with few or no kernels
    """

    def __init__(self, *, displayed: bool, compiles: bool = True) -> None:
        self._displayed, self._compiles = displayed, compiles
        self._wanted = displayed and sys.stderr.isatty()
        self._began = time.perf_counter()
        self._bar: tuple[Progress, TaskID] | None = None
        self._fraction, self._compiled = 0.0, 0
        self._listening = ExitStack()
        self._stage, self._stage_began, self._statement = "", self._began, self._began

    def __enter__(self) -> Bar:
        if self._wanted:
            from camsim.core.kernels import compiling

            self._listening.enter_context(compiling(self._say_what_is_compiled))
        self._compile()
        return self

    def _compile(self) -> None:
        """Compile at the first use on a machine, with a message also in log files."""
        if not self._compiles:
            return
        from camsim.rendering import compile_kernels, kernels_compiled

        if not kernels_compiled():
            if self._displayed:
                print("camsim: compiling its kernels, once on this machine (about 20 s)", file=sys.stderr)
            compile_kernels()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._listening.close()
        if self._bar is not None:
            self._bar[0].stop()

    def _say_what_is_compiled(self, kernel: str) -> None:
        self._compiled += 1
        self.update(f"compiling, once on this machine: {kernel} ({self._compiled})", self._fraction)

    def update(self, stage: str, fraction: float) -> None:
        """Display the current stage and the fraction done."""
        if not self._wanted:
            if self._displayed:
                self._say_in_a_line(stage, fraction)
            return
        self._fraction = fraction
        if self._bar is None:
            if time.perf_counter() - self._began < _AFTER_S:
                return
            self._bar = _start()
        progress, task = self._bar
        progress.update(task, description=stage, completed=fraction)

    def _say_in_a_line(self, stage: str, fraction: float) -> None:
        now = time.perf_counter()
        if stage != self._stage:
            self._stage, self._stage_began, self._statement = stage, now, now
        if now - self._statement < _LINE_EVERY_S:
            return
        self._statement = now
        left = ""
        if 0.0 < fraction < 1.0:
            left = f", about {duration((now - self._stage_began) * (1.0 / fraction - 1.0))} left"
        print(f"camsim: {stage}, {percent(fraction)}{left}", file=sys.stderr, flush=True)


def _start() -> tuple[Progress, TaskID]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    progress = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    progress.start()
    return progress, progress.add_task("", total=1.0)
