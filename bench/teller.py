"""How far a long run is, on stderr."""

from __future__ import annotations

import sys
import time

EVERY_S = 2.0


class Teller:
    """Says how far the work is and how long it may yet take: every two seconds, on one line if it can."""

    def __init__(self, *, displayed: bool = True) -> None:
        self._displayed, self._began, self._last = displayed, time.perf_counter(), -EVERY_S
        self._over = "\r\x1b[K" if sys.stderr.isatty() else ""

    def tell(self, fraction: float, words: str) -> None:
        """Say which fraction is done, and what was done last."""
        now = time.perf_counter() - self._began
        if not self._displayed or (now - self._last < EVERY_S and fraction < 1.0):
            return
        self._last = now
        left = f", about {duration(now * (1.0 - fraction) / fraction)} left" if 0.0 < fraction < 1.0 else ""
        end = "\n" if not self._over or fraction >= 1.0 else ""
        print(f"{self._over}{100.0 * fraction:3.0f} %  {words}{left}", file=sys.stderr, end=end, flush=True)


def duration(seconds: float) -> str:
    """Return a duration in words.

    >>> duration(42.4), duration(160.0)
    ('42 s', '3 min')
    """
    return f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"
