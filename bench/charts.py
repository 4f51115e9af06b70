"""How long charts take, warm: ``python -m bench.charts [siemens-star] [dead-leaves] [page]``.

Promised for 2 cores: a star of 144 cycles at 1e-6 on 1024 × 1024 photosites, and dead leaves of 20 000 discs at 1e-4 on
3008 × 2000 photosites behind a Bayer filter. A page of 10 000 glyphs is to be no slower than as many polygons of as
many edges: ``page`` says how many times as much of all cores it takes (``--letters 20``: of 400, on as little a frame).
As many edges is what is rendered: the sides that the letters' curves became, as corners that somebody gave. Polygons
with as many corners as the letters have lines and curves are another scene, of far fewer edges: that is said as well.
"""

from __future__ import annotations

import argparse
import resource
import string
import time
from collections.abc import Callable, Sequence

import camsim
from camsim.scene import flattened

PITCH_UM = 4.88
LENS = camsim.Airy(f_number=5.6)


def siemens_star() -> str:
    star = camsim.charts.siemens_star(radius_um=500.0 * PITCH_UM, cycles=144, light=0.9)
    found = camsim.render(
        camsim.Scene(background=0.5, shapes=[star]),
        [LENS, camsim.SquarePhotosite(side_um=PITCH_UM)],
        camsim.Grid(rows=1024, cols=1024, pitch_um=PITCH_UM),
        wavelength_nm=550.0,
        tolerance=1e-6,
    )
    return f"{found.method}, error {found.error_estimate:.1e}"


def dead_leaves() -> str:
    camera = camsim.Camera.from_yaml("d40-like", lens=LENS)
    leaves = camsim.charts.dead_leaves(
        width_um=3008.0 * PITCH_UM,
        height_um=2000.0 * PITCH_UM,
        least_radius_um=8.0 * PITCH_UM,
        largest_radius_um=400.0 * PITCH_UM,
        discs=20_000,
        seed=1,
    )
    frame = camera.expose(
        camsim.Scene(background=0.35, shapes=[leaves]),
        light=camsim.Light("D65", illuminance_lux=2000.0),
        exposure=camsim.Exposure(time_s="auto", iso=200.0),
        tolerance=1e-4,
        seed=1,
    )
    return f"{frame.report.method}, error {frame.report.error_estimate:.1e}"


SIZE_UM = 12.0 * PITCH_UM  # of a letter
LETTERS, FRAME = 100, 1024  # in a line, and lines on the page; photosites along the frame


def _page(shapes: Sequence[camsim.scene.Shape], letters: int) -> camsim.Rendering:
    side = round(FRAME * letters / LETTERS)
    return camsim.render(
        camsim.Scene(background=0.9, shapes=shapes),
        [LENS, camsim.SquarePhotosite(side_um=PITCH_UM)],
        camsim.Grid(rows=side, cols=side, pitch_um=PITCH_UM),
        wavelength_nm=550.0,
        tolerance=1e-4,
        method="boundary",
    )


def page(letters: int) -> str:
    text = (string.ascii_letters + string.digits) * letters**2
    lines = "\n".join(text[k : k + letters] for k in range(0, letters**2, letters))
    glyphs = [camsim.Text(text=lines, size_um=SIZE_UM, align="centre", vertical="middle", line=0.8, reflectance=0.1)]
    began = time.process_time()
    found = _page(glyphs, letters)
    of_glyphs, step_um = time.process_time() - began, 0.8 * SIZE_UM
    drawn = sum(len(fill.curves.kind) for one in flattened(glyphs) for fill in one.fills)
    ratios = []
    for count in (found.work.edges, drawn):
        sides = max(3, round(count / letters**2))
        polygon = camsim.RegularPolygon(sides=sides, radius_um=0.3 * SIZE_UM, rotate_deg=1.0, reflectance=0.1)
        began = time.process_time()
        _page([camsim.RepeatOnGrid(shapes=[polygon], cols=letters, rows=letters, step_um=(step_um, step_um))], letters)
        ratios.append(f"{of_glyphs / (time.process_time() - began):.2f} of {sides}-sided polygons'")
    took = f"{of_glyphs:.1f} s of all cores, {', '.join(ratios)}"
    return f"{found.method}, error {found.error_estimate:.1e}, {found.work.edges} edges, {took}"


CASES: dict[str, Callable[[int], str]] = {
    "siemens-star": lambda _: siemens_star(),
    "dead-leaves": lambda _: dead_leaves(),
    "page": page,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[[], *CASES], help="only these")
    parser.add_argument("--runs", type=int, default=2, help="the first one compiles")
    parser.add_argument("--letters", type=int, default=LETTERS, help="in a line, and lines on the page")
    chosen = parser.parse_args()
    for name in chosen.names or CASES:
        for _ in range(chosen.runs):
            began, worked = time.perf_counter(), time.process_time()
            said = CASES[name](chosen.letters)
            seconds, of_cores = time.perf_counter() - began, time.process_time() - worked
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
            print(f"{name:13} {seconds:7.2f} s, {of_cores:7.2f} s of all cores, peak {peak:.2f} GB; {said}", flush=True)


if __name__ == "__main__":
    main()
