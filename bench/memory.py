"""The memory that a process holds, and the most that it has held."""

from __future__ import annotations

import sys
from pathlib import Path


def peak_memory_mb() -> float | None:
    """Return the most memory this process has held since ``forget_peak``; None where the system does not say."""
    return _status_mb("VmHWM")


def held_memory_mb() -> float | None:
    """Return the memory this process holds; None where the system does not say."""
    return _status_mb("VmRSS")


def forget_peak() -> bool:
    """Let the peak begin anew; False where the system cannot."""
    if sys.platform != "linux":
        return False
    try:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    except OSError:
        return False
    return True


def _status_mb(key: str) -> float | None:
    if sys.platform != "linux":
        return None
    for line in Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines():
        if line.startswith(key):
            return int(line.split()[1]) * 1024 / 1e6
    return None
