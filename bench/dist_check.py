"""Build the wheel and the sdist, install each where nothing else is, and try them: ``make dist-check``.

Each goes into an environment of its own with nothing but what it asks for. The wheel is used from an empty folder, the
package's own files read-only; the sdist is unpacked and runs its own tests. Prints sizes; stops at the first failure.
"""

from __future__ import annotations

import argparse
import os
import stat
import subprocess
import sys
import tarfile
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
SMOKE = """
import camsim, numpy as np
frame = camsim.capture("flat-field", overrides=["region.rows=16", "region.cols=16"], seed=7)
camsim.save(frame, "python.dng")
grid = camsim.Grid(rows=8, cols=8, pitch_um=4.88)
square = camsim.Rectangle(width_um=20.0, height_um=20.0, reflectance=0.0)
scene = camsim.Scene(background=1.0, shapes=[square])
image = camsim.render(scene, [camsim.Airy(f_number=8.0)], grid, wavelength_nm=550.0)
assert image.image.shape == (8, 8) and np.isfinite(image.image).all()
"""


def main() -> None:
    """Build, install, try."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tests", nargs="*", help="of the sdist: those to run (all)")
    chosen = parser.parse_args().tests
    with tempfile.TemporaryDirectory(prefix="camsim-dist-") as folder:
        here = Path(folder)
        _run([sys.executable, "-m", "build", "--outdir", here / "dist", ROOT], here)
        wheel, sdist = *(here / "dist").glob("*.whl"), *(here / "dist").glob("*.tar.gz")
        for made in (wheel, sdist):
            print(f"{made.name}: {made.stat().st_size / 1e6:.2f} MB", flush=True)
        _try_wheel(wheel, here)
        _try_sdist(sdist, here, chosen)


def _try_wheel(wheel: Path, here: Path) -> None:
    python = _environment(here / "wheel-env", str(wheel))
    empty = here / "empty"
    empty.mkdir()
    for path in (here / "wheel-env").rglob("site-packages/camsim/**/*"):
        path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))
    camsim = python.with_name("camsim")
    for words in (
        ["--version"],
        ["list", "sensors"],
        ["show", "d40-like"],
        ["show", "double-gauss"],
        ["new", "scene"],
        ["validate", "scene.yaml"],
        ["explain", "slanted-edge"],
        ["capture", "slanted-edge", "-q", "-o", "edge.dng", "-o", "edge.png", "-o", "edge.exr"],
        ["info", "edge.dng"],
        ["measure", "mtf", "edge.dng"],
        ["recapture", "edge.dng", "-q", "-o", "again.dng"],
    ):
        _run([camsim, *words], empty)
    if (empty / "edge.dng").read_bytes() != (empty / "again.dng").read_bytes():
        sys.exit("recapture gave other bytes")
    _run([python, "-c", SMOKE], empty)
    print("wheel: installed, captured, measured and captured again", flush=True)


def _try_sdist(sdist: Path, here: Path, chosen: list[str]) -> None:
    with tarfile.open(sdist) as archive:
        archive.extractall(here / "unpacked", filter="data")
    (tree,) = (here / "unpacked").iterdir()
    python = _environment(here / "sdist-env", f"{tree}[test,lint]")
    # Whatever is chosen of them, every one is there with what it needs.
    _run([python, "-m", "pytest", "-q", "--collect-only"], tree)
    side_by_side = ["-n", "auto", "--maxprocesses", "4", "--dist", "worksteal"]
    _run([python, "-m", "pytest", "-q", *side_by_side, *chosen], tree)
    print("sdist: installed, its tests pass", flush=True)


def _environment(folder: Path, wanted: str) -> Path:
    """Return the interpreter of a new environment that holds what was wanted and what that asks for."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    _run([python, "-m", "pip", "install", "--quiet", wanted], folder)
    return python


def _run(words: list[str | Path], folder: Path) -> None:
    """Run a command in a folder; what it prints is shown when it fails."""
    alone = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run([str(word) for word in words], cwd=folder, env=alone, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))}\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    main()
