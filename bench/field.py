"""What a lens that changes over the frame takes, against a perfect one.

    python -m bench.field [ROWS COLS TOLERANCE [d55]]

Slanted edges in a window of a 3008 × 2000 frame, 200 × 300 without arguments: one wavelength, no noise; or with
``d55`` in daylight behind Bayer filters, noise on, to a DNG.
"""

from __future__ import annotations

import dataclasses
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering.render import plan_render, render_channels

PITCH_UM, NM = 7.8, 550.0
SQUARE_UM, APART_UM = 600.0, 1200.0


def scene_of(grid: camsim.Grid) -> camsim.Scene:
    """Squares turned by 5° all over the window."""
    x0, y0 = (grid.pitch_um * place for place in grid.first_centre)
    squares = [
        camsim.Rectangle(width_um=SQUARE_UM, height_um=SQUARE_UM, centre_um=(x, y), rotate_deg=5.0, reflectance=0.05)
        for x in np.arange(x0 + 0.5 * APART_UM, x0 + grid.cols * grid.pitch_um, APART_UM)
        for y in np.arange(y0 + 0.5 * APART_UM, y0 + grid.rows * grid.pitch_um, APART_UM)
    ]
    return camsim.Scene(background=0.9, shapes=squares)


def taken(lens: object, grid: camsim.Grid, tolerance: float) -> float:
    """Print what a lens takes; return CPU seconds."""
    system = OpticalSystem.of([lens, camsim.SquarePhotosite(side_um=PITCH_UM)])
    what = {"response": np.ones((1, 1)), "wavelength_nm": np.array([NM]), "tolerance": tolerance}
    plan = plan_render(scene_of(grid), system, grid, **what).plan
    for decision in plan.decisions():
        if decision.topic in ("field", "distortion"):
            print(f"  {decision.topic}: {decision.decision}")
    began = time.process_time()
    channel = np.zeros((grid.rows, grid.cols), np.uint8)
    found = render_channels(scene_of(grid), system, grid, channel=channel, **what)
    seconds = time.process_time() - began
    print(f"  {lens!r}: {seconds:.3g} CPU s, error {found.error_estimate:.2g} of {tolerance:g}")
    return seconds


def taken_in_daylight(lens: object, grid: camsim.Grid, tolerance: float) -> float:
    """Print what a capture takes; return CPU seconds."""
    camera = camsim.Camera.from_yaml("d40-like", lens=lens)
    with tempfile.TemporaryDirectory() as folder:
        began, clock = time.process_time(), time.perf_counter()
        frame = camera.expose(
            scene_of(dataclasses.replace(grid, pitch_um=camera.pitch_um)),
            light=camsim.Light("D55", illuminance_lux=5000.0),
            exposure=camsim.Exposure(time_s=0.01, iso=200),
            region=camsim.Region(rows=grid.rows, cols=grid.cols, origin=grid.origin),
            tolerance=tolerance,
            seed=1,
        )
        frame.save(Path(folder) / "field.dng")
        seconds, wall = time.process_time() - began, time.perf_counter() - clock
    error, checked = frame.report.error_estimate, frame.report.checked_photosites
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"  {lens!r}: {seconds:.3g} CPU s, {wall:.3g} s, error {error:.2g} of {tolerance:g} at {checked} photosites, "
        f"{peak_mb:.0f} MB in all"
    )
    return seconds


def main() -> None:
    """Take both lenses."""
    rows, cols, tolerance = (*map(int, sys.argv[1:3]), float(sys.argv[3])) if len(sys.argv) > 3 else (200, 300, 1e-3)
    grid = camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH_UM, frame=(2000, 3008))
    take = taken_in_daylight if sys.argv[4:] == ["d55"] else taken
    few = camsim.Grid(rows=24, cols=24, pitch_um=PITCH_UM, frame=(2000, 3008))
    for lens in (camsim.Airy(f_number=5.0), camsim.read_lens("double-gauss")):
        take(lens, few, 1e-2)  # compiles
    perfect = take(camsim.Airy(f_number=5.0), grid, tolerance)
    field = take(camsim.read_lens("double-gauss"), grid, tolerance)
    print(f"{rows} × {cols} at {tolerance:g}: {field / perfect:.3g} times the perfect lens")


if __name__ == "__main__":
    main()
