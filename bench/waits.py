"""How long people wait for the smallest things: ``python bench/waits.py`` on an idle machine.

The help and a capture of a shipped scene, each as a process of its own with its imports, kernels compiled before. The
shortest of some runs counts: other work on the machine only ever adds.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time

MOST_S = {("--help",): 0.5, ("capture", "slanted-edge", "--force", "-q"): 3.0}


def shortest_s(arguments: tuple[str, ...], folder: str, repeats: int = 5) -> float:
    """Return the wall time of the quickest of ``repeats`` runs, after one that warms up."""
    seconds = []
    for _ in range(repeats + 1):
        began = time.perf_counter()
        subprocess.run([sys.executable, "-m", "camsim", *arguments], cwd=folder, stdout=subprocess.DEVNULL, check=True)
        seconds.append(time.perf_counter() - began)
    return min(seconds[1:])


def main() -> None:
    slow = False
    with tempfile.TemporaryDirectory() as folder:
        for arguments, most_s in MOST_S.items():
            took_s = shortest_s(arguments, folder)
            slow |= took_s > most_s
            print(f"camsim {' '.join(arguments)}: {took_s:.2f} s (at most {most_s:g} s on an idle machine)")
    sys.exit(1 if slow else 0)


if __name__ == "__main__":
    main()
