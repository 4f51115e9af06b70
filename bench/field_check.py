"""A whole frame through the double Gauss, recomputed and measured.

    python -m bench.field_check [ROWS COLS TOLERANCE COUNT]

Slanted squares in D55 on Bayer photosites (``bench.field``), noise off, the whole frame without arguments. Of COUNT
photosites (64) a quarter lie anywhere, a quarter within three photosites of an edge, and half likewise on either side
of a border of tiles: each is recomputed with the pattern of its own place. Then a DNG is written, and the MTF of twenty
sides, from the axis to the corner, is measured from it and compared with theory there.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy

import camsim
from bench.field import SQUARE_UM, scene_of
from camsim.measure import CameraOtf, Roi, measure_mtf, read_picture
from camsim.measure.geometry import EdgeLine
from camsim.optical_image import OpticalImage
from camsim.rendering.varying import VaryingPlan
from camsim.rendering.waves.image import tiles

NEAR = 3.0  # photosites from an edge
DRAWN = 2000  # of which those near edges are taken
SIDES, LONG, WIDE = 20, 100, 80  # that are measured, and photosites about each
KNOTS = 17  # frequencies of theory


def distance(plan: VaryingPlan, rows: np.ndarray, cols: np.ndarray) -> np.ndarray:
    """Return how far photosites lie from the nearest edge, pitches."""
    edges, (x0, y0) = plan.job.edges, plan.job.grid.first_centre
    along = edges.end - edges.start
    squared = np.sum(along**2, axis=1)
    found = np.empty(rows.size)
    for k, place in enumerate(np.stack([x0 + cols, y0 + rows], axis=1)):
        t = np.clip(np.sum((place - edges.start) * along, axis=1) / squared, 0.0, 1.0)
        found[k] = np.sqrt(np.sum((edges.start + t[:, None] * along - place) ** 2, axis=1).min())
    return found


def places(plan: VaryingPlan, count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return rows, columns and whose they are: 0 anywhere, 1 near an edge, 2 near one and at a border of tiles."""
    grid, quarter = plan.job.grid, count // 4
    rows, cols = rng.integers(0, grid.rows, DRAWN), rng.integers(0, grid.cols, DRAWN)
    near = np.flatnonzero(distance(plan, rows, cols) < NEAR)[:quarter]
    at_rows, at_cols = rng.integers(0, grid.rows, 4 * DRAWN), rng.integers(0, grid.cols, 4 * DRAWN)
    first = np.array([(row, col) for row, col, _, _ in tiles((grid.rows, grid.cols))])
    borders = [np.unique(own)[1:] for own in first.T]
    beside = rng.integers(0, 2, 4 * DRAWN)
    down = rng.integers(0, 2, 4 * DRAWN) == 0
    for own, border, here in ((at_rows, borders[0], down), (at_cols, borders[1], ~down)):
        if border.size:
            own[here] = (rng.choice(border, own.size) - beside)[here]
    at = np.flatnonzero(distance(plan, at_rows, at_cols) < NEAR)[: count - 2 * quarter]
    whose = np.repeat([0, 1, 2], [quarter, near.size, at.size])
    return (
        np.concatenate([rows[-quarter:], rows[near], at_rows[at]]),
        np.concatenate([cols[-quarter:], cols[near], at_cols[at]]),
        whose,
    )


class Sparse:
    """Theory at few frequencies, splines between them: a field lens's transfer takes long at each."""

    def __init__(self, theory: CameraOtf) -> None:
        self.theory = theory

    def along_normal(self, frequency_cycles_per_pixel: np.ndarray, *, channel: str, line: EdgeLine) -> np.ndarray:
        """Transfer function across an edge; beyond the sensor's Nyquist frequency nothing."""
        few = np.linspace(0.0, 0.5, KNOTS)
        spline = scipy.interpolate.CubicSpline(few, self.theory.along_normal(few, channel=channel, line=line))
        return np.where(frequency_cycles_per_pixel <= 0.5, spline(frequency_cycles_per_pixel), 0.0)


def measured(capture: camsim.Capture, seen: OpticalImage) -> None:
    """Print how far the MTF of sides of the squares, measured from a file, is from theory."""
    pitch_um, lens = capture.camera.pitch_um, capture.camera.lens
    (left, top), grid = capture.grid.first_centre, capture.grid
    frame = next(capture.frames(optical_image=seen))
    with tempfile.TemporaryDirectory() as folder:
        frame.save(Path(folder) / "field.dng")
        picture = read_picture(Path(folder) / "field.dng")
    rois = []
    for number, square in enumerate(capture.scene.shapes):
        turn = np.deg2rad(square.rotate_deg + 90.0 * (number % 2))  # the side to the right, or the one below
        side = np.array(square.centre_um) + 0.5 * SQUARE_UM * np.array([np.cos(turn), np.sin(turn)])
        x, y = lens.distorted(side[None])[0] / pitch_um
        tall, wide = (WIDE, LONG) if number % 2 else (LONG, WIDE)
        roi = Roi(round(y - top - 0.5 * tall), round(x - left - 0.5 * wide), tall, wide)
        if min(roi.row, roi.col) >= 0 and roi.row + tall <= grid.rows and roi.col + wide <= grid.cols:
            rois.append((float(np.hypot(x, y)), roi))
    rois.sort(key=lambda one: one[0])
    taken = [rois[k] for k in np.unique(np.linspace(0, len(rois) - 1, SIDES).round().astype(int))]
    report = measure_mtf(picture, rois=[roi for _, roi in taken], theory=Sparse(CameraOtf.of(capture)))
    worst: dict[str, float] = {}
    for edge in report.edges:
        assert edge.theory is not None
        heard = edge.frequency_cycles_per_pixel <= edge.nyquist_cycles_per_pixel
        off = float(np.abs(edge.mtf - edge.theory.mtf)[heard].max())
        worst[edge.channel] = max(worst.get(edge.channel, 0.0), off)
        print(f"  {report.place(edge).radius_pixel:6.0f} px from the axis, {edge.channel}: ΔMTF {off:.2g}")
    said = ", ".join(f"{channel} {off:.2g}" for channel, off in worst.items())
    print(f"{len(taken)} sides, up to each channel's Nyquist frequency, the largest |ΔMTF|: {said}", flush=True)


def main() -> None:
    """Render, measure, and compare."""
    given = sys.argv[1:]
    rows, cols, tolerance = (int(given[0]), int(given[1]), float(given[2])) if len(given) > 2 else (2000, 3008, 1e-3)
    count = int(given[3]) if len(given) > 3 else 64
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.read_lens("double-gauss"))
    region = camsim.Region(rows=rows, cols=cols, origin=(0, 0))  # with the corner, where patterns change most
    grid = camera.grid(region)
    capture = camsim.Capture(
        camera=camera,
        scene=scene_of(grid),
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200),
        region=region,
        tolerance=tolerance,
        noise=False,
    )
    began = time.process_time()
    seen = capture.optical_image()
    choice, rendering, channels = seen.choice, seen.rendering, capture.window.channels_of_all()
    plan = choice.plan
    assert isinstance(plan, VaryingPlan)
    print(f"{rows} × {cols} at {tolerance:g}: {time.process_time() - began:.0f} CPU s", flush=True)
    measured(capture, seen)
    at_rows, at_cols, whose = places(plan, count, np.random.default_rng(1))
    sets = channels[at_rows, at_cols]
    began = time.process_time()
    right = choice.judge.values(at_rows, at_cols, sets)
    checked = time.process_time() - began
    off = np.abs(rendering.image[at_rows, at_cols] / plan.job.signals.scale[sets] - right)
    print(f"{off.size} photosites recomputed: {checked:.0f} CPU s")
    for number, name in enumerate(("anywhere", "near edges", "at borders of tiles, near edges")):
        mine = off[whose == number]
        if mine.size:
            print(f"  {mine.size} {name}: the worst {mine.max():.2g}, {mine.max() / tolerance:.2g} of the tolerance")
    print(f"  {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB in all")


if __name__ == "__main__":
    main()
