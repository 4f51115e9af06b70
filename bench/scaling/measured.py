"""Time and memory against size: curves, and the figures that large frames are asked for.

    python -m bench.scaling curves     # into out/scaling; what is stored: -o bench/scaling
    python -m bench.scaling large      # large frames: seconds, and ratios of one run
    python -m bench.scaling paper      # the paper's square from f/1.4 to f/32

Every case runs in a process of its own, after a small one that loads the kernels. On a busy machine read CPU seconds
and ratios; wall time is worth something only where nobody else computes.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import camsim
from bench.memory import forget_peak, held_memory_mb, peak_memory_mb
from bench.report import close
from bench.results import Results, of_kind
from bench.scaling.sizes import run_scaling
from bench.teller import Teller
from bench.worker import GIVES_BACK, Worker
from camsim.bench.records import Line
from camsim.core.cores import cores

PITCH_UM = 4.88
ROWS, COLS = 2000, 3008
PAPER = (1.4, 2.8, 5.6, 8.0, 16.0, 32.0)  # f-numbers of the paper's square
FIGURES = {"edges": "edges over 3008 × 2000 photosites, f/8, 1e-5", "photosites": "photosites, a square, f/8, 1e-6"}


class _Clock:
    """Clocks a rendering, and in it the loop over photosites, and what came before its first turn."""

    def __init__(self) -> None:
        import camsim.rendering.boundary.image as engine

        self.loop_s, self.entered, self.setup_s = 0.0, 0.0, 0.0
        self._began = 0.0
        self._engine, self._kernel = engine, engine.render_edges

    def _timed(self, *arguments: Any) -> Any:
        began, cpu = time.perf_counter(), time.process_time()
        if not self.entered:
            self.entered, self.setup_s = began, cpu - self._began
        image = self._kernel(*arguments)
        self.loop_s += time.process_time() - cpu
        return image

    def run(self, work: Callable[[], Any]) -> dict[str, float]:
        """Return seconds and MB."""
        held = held_memory_mb() if forget_peak() else None
        self._engine.render_edges = self._timed
        began, cpu = time.perf_counter(), time.process_time()
        self._began = cpu
        done = work()
        figures = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - cpu, "loop_s": self.loop_s}
        self._engine.render_edges = self._kernel
        peak = peak_memory_mb()
        if self.entered:
            figures |= {"setup_wall_s": self.entered - began, "setup_cpu_s": self.setup_s}
        if held is not None and peak is not None:
            figures |= {"beyond_mb": peak - held, "peak_mb": peak}
        if isinstance(done, camsim.Rendering):
            figures["error_estimate"] = done.error_estimate
        return figures


def _optics(f_number: float, *, olpf: bool) -> list[Any]:
    spots = [camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM)] if olpf else []
    return [camsim.Airy(f_number=f_number), *spots, camsim.SquarePhotosite(side_um=PITCH_UM)]


def _squares(count: int, side: tuple[float, float], rows: int, cols: int) -> list[camsim.Rectangle]:
    """Squares at random angles in cells of their own; sides in pitches."""
    rng = np.random.default_rng(11)
    across = int(np.ceil(np.sqrt(count * cols / rows)))
    cell = np.array([cols / across, rows / np.ceil(count / across)])
    shapes = []
    for k in range(count):
        x, y = (np.array([k % across, k // across]) + 0.5) * cell - 0.5 * np.array([cols, rows])
        size = rng.uniform(*side) * PITCH_UM
        shapes.append(
            camsim.Rectangle(
                width_um=size,
                height_um=size,
                centre_um=(x * PITCH_UM, y * PITCH_UM),
                rotate_deg=rng.uniform(0.0, 90.0),
                reflectance=0.0,
            )
        )
    return shapes


def mono(
    shapes: list[camsim.Rectangle], rows: int, cols: int, tolerance: float, f_number: float, olpf: bool, method: str
) -> dict[str, float]:
    """Render at 550 nm."""
    scene = camsim.Scene(background=1.0, shapes=shapes)
    grid = camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH_UM)
    optics = _optics(f_number, olpf=olpf)
    return _Clock().run(
        lambda: camsim.render(scene, optics, grid, wavelength_nm=550.0, tolerance=tolerance, method=method)
    )


def colour(chart: bool, rows: int, cols: int) -> dict[str, float]:
    """Render a slanted edge, or a ColorChecker, in D55 for the D40-like sensor's own filters; nothing but rendering."""
    from camsim.rendering.running import carry_out

    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    shapes = [slanted()]
    if chart:
        from camsim.spectra.named import reflectance_names

        patches = [name for name in reflectance_names() if "/" not in name][:24]
        side = 0.8 * cols / 7 * PITCH_UM
        shapes = [
            camsim.Rectangle(
                width_um=side,
                height_um=side,
                centre_um=((k % 6 - 2.5) * 1.2 * side, (k // 6 - 1.5) * 1.2 * side),
                reflectance=camsim.reflectance(name),
            )
            for k, name in enumerate(patches)
        ]
    capture = camsim.Capture(
        camera=camera,
        scene=camsim.Scene(background=0.9, shapes=shapes),
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        region=camsim.Region(rows=rows, cols=cols),
        tolerance=1e-6,
    )
    channel = camera.cfa.tiled_index(rows, cols, capture.grid.origin)
    assert capture.samples.wavelength_nm.size  # the light is there before the clock runs
    return _Clock().run(lambda: carry_out(capture.plan(), channel))


def slanted() -> camsim.Rectangle:
    """A square of 1200 pitches turned by 4°."""
    side = 1200.0 * PITCH_UM
    return camsim.Rectangle(width_um=side, height_um=side, rotate_deg=4.0, reflectance=0.05)


def _alone(function: Callable[..., dict[str, float]], *arguments: Any, laps: int = 1) -> dict[str, float]:
    """Run in a process of its own, kernels loaded; the quickest of several laps, by CPU time.

    Memory is another process's, which gives back what it frees: that costs time, as nobody has it who does not ask.
    """
    memory = _laps(GIVES_BACK, 1, function, *arguments)[0]
    quickest = min(_laps({}, laps, function, *arguments), key=lambda found: found["cpu_s"])
    return quickest | {name: value for name, value in memory.items() if name.endswith("_mb")}


def _laps(
    environment: dict[str, str], laps: int, function: Callable[..., dict[str, float]], *arguments: Any
) -> list[dict[str, float]]:
    with Worker(threads=cores(), environment=environment) as worker:
        worker.call(mono, [slanted()], 32, 32, 1e-3, 8.0, False, "boundary")
        return [worker.call(function, *arguments) for _ in range(laps)]


def _tell(name: str, found: dict[str, float]) -> None:
    words = "  ".join(f"{key} {value:.3g}" for key, value in found.items())
    print(f"{name:44} {words}", flush=True)


def large() -> None:
    """Measure what the large frames are asked for."""
    crowd, squares = _squares(25_000, (1.0, 3.9), ROWS, COLS), _squares(100, (260.0, 260.0), 4000, 6000)
    _tell("100 000 edges, 3008 × 2000, 1e-5", _alone(mono, crowd, ROWS, COLS, 1e-5, 8.0, False, "auto"))
    _tell("100 squares, 6000 × 4000, 1e-6", _alone(mono, squares, 4000, 6000, 1e-6, 8.0, False, "auto"))
    one = _alone(mono, [slanted()], ROWS, COLS, 1e-6, 8.0, True, "auto", laps=5)
    bayer, chart = (_alone(colour, is_chart, ROWS, COLS, laps=5) for is_chart in (False, True))
    _tell("slanted edge, one wavelength, 3008 × 2000", one)
    _tell("slanted edge, Bayer, D55", bayer)
    _tell("ColorChecker, Bayer, D55", chart)
    for name, found in (("slanted edge", bayer), ("ColorChecker", chart)):
        ratios = (f"{key} {found[f'{key}_s'] / one[f'{key}_s']:.2f} ×" for key in ("wall", "cpu", "loop"))
        print(f"{name}: {', '.join(ratios)} of one wavelength's slanted edge")


def paper() -> None:
    """Measure the paper's square over f-numbers, with and without OLPF."""
    square = camsim.Rectangle(width_um=250 * PITCH_UM, height_um=250 * PITCH_UM, rotate_deg=4.0, reflectance=0.0)
    for olpf in (False, True):
        by_f = {n: _alone(mono, [square], 446, 446, 1e-6, n, olpf, "auto", laps=9)["cpu_s"] for n in PAPER}
        print(
            f"paper's square{' + OLPF' if olpf else ''}: "
            + "  ".join(f"f/{n:g} {1e3 * s:.0f} ms ({s / by_f[8.0]:.2f} ×)" for n, s in by_f.items())
        )


def slope(sizes: list[float], seconds: list[float]) -> float:
    """Power of growth over the upper half of the sizes, by least squares of the logarithms."""
    upper = len(sizes) // 2
    return float(np.polyfit(np.log(sizes[upper:]), np.log(seconds[upper:]), 1)[0])


def draw(lines: list[Line], over: str, path: Path) -> None:
    """Draw CPU time, with the power of its growth, and memory against size."""
    from matplotlib.figure import Figure

    mine = [line for line in of_kind(lines, "scaling") if line["over"] == over]
    sizes, seconds = [line["size"] for line in mine], [line["cpu_s"] for line in mine]
    power = slope(sizes, seconds)
    fitted = [seconds[-1] * (size / sizes[-1]) ** power for size in sizes]
    figure = Figure(figsize=(9.2, 4.2), layout="constrained")
    times, memory = figure.subplots(1, 2)
    times.loglog(sizes, fitted, "--", color="#777777", label=f"power {power:.2f}")
    times.loglog(sizes, seconds, "o-", color="#0072B2", label="CPU, all threads added")
    times.set_ylim(min(fitted + seconds) / 2.0, 5.0 * max(seconds))
    times.set_ylabel("seconds, set-up and check included")
    times.legend(frameon=False, loc="upper left")
    weighed = [(line["size"], line["beyond_mb"]) for line in mine if line.get("beyond_mb")]
    memory.loglog(*zip(*weighed, strict=True), "o-", color="#009E73")
    memory.set_ylim(min(mb for _, mb in weighed) / 4.0, 4.0 * max(mb for _, mb in weighed))
    memory.set_ylabel("peak memory beyond the program's own, MB")
    for axes in (times, memory):
        axes.set_xlabel(FIGURES[over])
        axes.grid(which="major", alpha=0.3)
    figure.savefig(path, dpi=130)


def curves(folder: Path, figures: Path) -> None:
    """Clock every size and draw."""
    with Results(folder / "results.jsonl") as results:
        results.start(quick=False)
        with close(results, "scaling.html"):
            run_scaling(results, Teller().tell)
    for over in FIGURES:
        draw(results.lines, over, figures / f"scaling-{over}.png")


def main() -> None:
    """Run what the command line names."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("curves", "large", "paper"))
    parser.add_argument("-o", "--output", type=Path, default=Path("out/scaling"), metavar="DIR", help="of the curves")
    parser.add_argument("--figures", type=Path, metavar="DIR", help="of the curves; the same folder when left out")
    asked = parser.parse_args()
    if asked.what == "curves":
        curves(asked.output, asked.figures or asked.output)
    else:
        {"large": large, "paper": paper}[asked.what]()
