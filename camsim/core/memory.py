"""Estimates of memory, to refuse a frame that does not fit before the work begins."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterator
from pathlib import Path

# Measured on frames of 6 million photosites, rounded up: mean and noisy electrons, codes and working copies;
# the truth for each of its channels; and the preview while it is developed.
_BYTES_PER_PHOTOSITE = 40
_BYTES_PER_TRUTH = 16
_BYTES_PER_PREVIEW = 70


# Measured on frames of 6 to 150 million photosites, rounded up: a band hardly depends on the frame.
_BYTES_PER_PASSING_PHOTOSITE = 0.2
_BYTES_PER_BAND = 200_000_000

_THERE_BYTES = 16e6  # assumed to be available: a query takes a twentieth of a small window's time


def needed_bytes(rows: int, cols: int, channels: int, products: Collection[str], *, held: bool = True) -> int:
    """Return the approximate memory of a capture in addition to the program's, bytes.

    held : False if its codes are written to the file as they are finished, and at most a band is in memory
    """
    truth = _BYTES_PER_TRUTH * channels if "truth" in products else 0
    preview = _BYTES_PER_PREVIEW if "preview" in products else 0
    whole = rows * cols * (_BYTES_PER_PHOTOSITE + truth + preview)
    return whole if held else min(whole, _BYTES_PER_BAND + int(rows * cols * _BYTES_PER_PASSING_PHOTOSITE))


def too_large(rows: int, cols: int, needed: float) -> str:
    """Return why photosites do not fit in memory, as the beginning of a message; empty if they fit.

    >>> too_large(4, 4, 1e6)
    ''
    """
    if needed <= _THERE_BYTES or needed <= (free := available_bytes()):
        return ""
    return f"{rows} × {cols} photosites need about {readable(needed)} of memory, {readable(free)} are free"


def available_bytes() -> int:
    """Return the memory available to this process, bytes, by the strictest known limit."""
    return min(_limits(), default=sys.maxsize)


def readable(size_bytes: float) -> str:
    """Return a size in the largest unit in which it is at least 1.

    >>> readable(3.21e9), readable(880_000), readable(6.4e15)
    ('3.2 GB', '880 kB', '6400 TB')
    """
    power = min(4, max(0, int(math.log10(max(size_bytes, 1.0)) // 3)))
    value = size_bytes / 1000**power
    return f"{value:.0f} {_UNITS[power]}" if value >= 10 or power == 0 else f"{value:.1f} {_UNITS[power]}"


_UNITS = ("bytes", "kB", "MB", "GB", "TB")


def _limits() -> Iterator[int]:
    import psutil  # imported here, as small windows do not need it

    yield int(psutil.virtual_memory().available)
    # A container may have a lower limit than its machine, which psutil ignores.
    for limit, used in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"),
    ):
        most, now = _text(limit).strip(), _text(used).strip()
        if most.isdecimal() and now.isdecimal():
            yield max(0, int(most) - int(now))
    try:
        import resource
    except ImportError:  # not on Windows
        return
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    if soft != resource.RLIM_INFINITY:
        yield max(0, soft - psutil.Process().memory_info().vms)


def _text(path: str) -> str:
    try:
        return Path(path).read_text()
    except OSError:
        return ""
