"""Why entries of the paper's tables differ from ours by more than a factor 1.5: ``python -m bench.paper.beyond``.

Each experiment renders the square as the paper's program may have done, in place of as camsim does, and sets the error
beside the printed entry. Four minutes on one core; five shifts of the edge, on the bench's window.

corner    : the window has the square's corner in it, an edge spread function has not
sequence  : camsim's samples are Halton's points from the first on, those of the program's source from the 20th
cut       : camsim cuts the Airy pattern at 18 λN; "18 units scaled by f-number" may be 18 µm times the f-number
rounding  : camsim's images are rounded to 16 bits; a cast cuts off
window    : an MTF from an edge profile of ± 16 px under a Hamming window, in eighths of a pixel
"""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy import optimize, special
from scipy.stats import qmc

from bench.paper import cases
from bench.paper.cases import Psf, Setting
from camsim.core.arrays import F64
from camsim.rendering.edges import Edges
from camsim.rendering.paper import rules

PRINTED: dict[str, Any] = json.loads((Path(__file__).parent / "printed.json").read_text(encoding="utf-8"))
ONE, THREE = PRINTED["table_1_rmse_gaussian"], PRINTED["table_3_rmse_airy"]
SHIFTS = cases.shifts_px(5)
FIRST = 20  # of Halton's points, in the program's published source
MICROMETRES = 18.0  # times the f-number
CORNER_ROWS = 20  # of the window: below them the edge is straight as far as the pattern reaches
HALF_PROFILE_PX, BINS = 16.0, 8.0
OFF_PX = 0.25  # along the edge's normal
CODES = 65535.0
Image = Callable[[F64], F64]


@functools.cache
def exact(psf: Psf) -> F64:
    """Return the windows (shifts, rows, cols) without sampling."""
    return windows(
        psf,
        lambda shift: cases.rendered(psf, Setting(method="auto", tolerance=1e-9), cases.window(), shift_px=shift).image,
    )


def windows(psf: Psf, image: Image) -> F64:
    """Return what a method draws at every shift."""
    return np.stack([image(shift) for shift in SHIFTS])


def ours(psf: Psf, method: str, samples: int | None = None) -> F64:
    """Return the windows by a method of camsim's."""
    setting = Setting(method=method, samples=samples)
    return windows(psf, lambda shift: cases.rendered(psf, setting, cases.window(), shift_px=shift).image)


def by_places(psf: Psf, places: F64) -> F64:
    """Return the windows by samples at places (n, 2) about each photosite, pitches; all count the same."""
    rule = rules.Rule(places=places, shares=np.full(len(places), 1.0 / len(places)))

    def image(shift: F64) -> F64:
        corners = cases.corners_px() + shift
        edges = Edges(start=corners, end=np.roll(corners, -1, axis=0), left=np.ones(4, int), right=np.zeros(4, int))
        shape = (cases.WINDOW_ROWS, cases.WINDOW_COLS)
        return rule.image(edges, np.full(4, -1.0), 1.0, origin=cases.window().first_centre, shape=shape)

    return windows(psf, image)


def halton(count: int, first: int = 1) -> F64:
    """Return points (n, 2) of the unit square."""
    return qmc.Halton(2, scramble=False).random(first + count)[first:]


def airy_places(psf: Psf, count: int, cut: float) -> F64:
    """Return camsim's samples of an Airy pattern, cut at another radius (λN)."""
    from camsim.optics import Airy

    return rules._importance(Airy(f_number=psf.f_number), float(psf.blurs_px()[0]), count, cut)[0]


def rms(error: F64, *, corner: bool = True) -> float:
    """Return the root mean square over the windows, or over their rows beside the straight edge."""
    some = error if corner else error[:, CORNER_ROWS:]
    return math.sqrt(float(np.mean(some**2)))


def rounded(image: F64) -> F64:
    """Return an image rounded to 16 bits."""
    return np.rint(CODES * np.clip(image, 0.0, 1.0)) / CODES


def cut_off(image: F64) -> F64:
    """Return an image cut off to 16 bits; what is white but for rounding stays white."""
    return np.floor(CODES * np.clip(image, 0.0, 1.0) + 1e-3) / CODES


def table_one() -> Iterator[tuple[str, str, list[float]]]:
    """Yield entry, experiment and ratio to the printed figure, for each MTF50."""
    for count in (121, 2025):
        column = ONE["columns"].index(f"{count}xIS")
        yield from _of_gaussians(
            f"{count}xIS",
            column,
            {
                "camsim's": lambda psf, count=count: ours(psf, "importance", count),
                f"Halton's from {FIRST}": lambda psf, count=count: by_places(
                    psf, float(psf.blurs_px()[0]) * special.ndtri(halton(count, FIRST))
                ),
            },
        )
    yield from _of_gaussians(
        "NI", 4, {"rounded": lambda psf: rounded(exact(psf)), "cut off": lambda psf: cut_off(exact(psf))}
    )
    turn = math.radians(cases.TURN_DEG)
    off = OFF_PX * np.array([math.cos(turn), math.sin(turn)])
    yield from _of_gaussians(
        "11x11xUP",
        0,
        {
            "camsim's": lambda psf: ours(psf, "uniform-pixel"),
            f"{OFF_PX:g} px off": lambda psf: windows(
                psf,
                lambda shift: (
                    cases.rendered(psf, Setting(method="uniform-pixel"), cases.window(), shift_px=shift + off).image
                ),
            ),
        },
    )


def _of_gaussians(
    entry: str, column: int, tried: dict[str, Callable[[Psf], F64]]
) -> Iterator[tuple[str, str, list[float]]]:
    for name, image in tried.items():
        errors = {f"{m:.2f}": image(psf) - exact(psf) for m in cases.MTF50S if (psf := cases.PSFS[f"gaussian-{m:.2f}"])}
        for corner in (True, False):
            ratios = [rms(error, corner=corner) / ONE["rows"][key][column] for key, error in errors.items()]
            yield entry, f"{name}, {'window' if corner else 'straight edge'}", ratios


def table_three() -> Iterator[tuple[str, str, list[float]]]:
    """Yield entry, experiment and ratio to the printed figure, for each f-number."""
    for count in (121, 2025, 40401):
        column = THREE["columns"].index(f"{count}xIS")
        for words, cut in (("18 λN", 18.0), ("18 µm · N", MICROMETRES * 1e3 / cases.WAVELENGTH_NM)):
            ratios = []
            for name, row in THREE["rows"].items():
                psf = cases.PSFS[f"airy-{name.replace('/', '')}"]
                ratios.append(rms(by_places(psf, airy_places(psf, count, cut)) - exact(psf)) / row[column])
            yield f"{count}xIS", f"cut at {words}", ratios


def table_two() -> Iterator[tuple[str, str, list[float]]]:
    """Yield what the measurement of the paper alone may be off by, per cent, and what sampling adds."""
    columns = PRINTED["table_2_mtf50_error_percent_gaussian"]
    yield "NI", "printed, %", [row[4] for row in columns["rows"].values()]
    yield "NI", "window and bins, %", [error_of_profile(m) for m in cases.MTF50S]
    for count in (121, 2025):
        for words, first in (("camsim's", 1), (f"Halton's from {FIRST}", FIRST)):
            yield f"{count}xIS", f"{words}: the samples' own MTF50, %", [error_of_samples(halton(count, first))]


def error_of_samples(points: F64) -> float:
    """Return by how much the MTF50 of a Gaussian drawn by samples is off, per cent, whatever measures it."""
    turn, half = math.radians(cases.TURN_DEG), math.sqrt(2.0 * math.log(2.0)) / (2.0 * math.pi)
    across = special.ndtri(points) @ [math.cos(turn), math.sin(turn)]

    def above_half(f: float) -> float:
        return float(np.abs(np.mean(np.exp(2j * math.pi * f * across)))) - 0.5

    return 100.0 * (float(optimize.brentq(above_half, 0.7 * half, 1.4 * half)) / half - 1.0)


def error_of_profile(mtf50: float) -> float:
    """Return by how much the MTF50 of a Gaussian is off, per cent, from a windowed profile in bins."""
    sigma = math.sqrt(math.log(2.0) / 2.0) / (math.pi * mtf50)
    x = np.linspace(-HALF_PROFILE_PX, HALF_PROFILE_PX, 8001)
    line = np.exp(-0.5 * (x / sigma) ** 2) * (0.54 + 0.46 * np.cos(math.pi * x / HALF_PROFILE_PX))

    def above_half(f: float) -> float:
        transfer = float(np.sum(line * np.cos(2.0 * math.pi * f * x)) / np.sum(line))
        return transfer * float(np.sinc(f / BINS)) - 0.5

    return 100.0 * (float(optimize.brentq(above_half, 0.5 * mtf50, 2.0 * mtf50)) / mtf50 - 1.0)


def main() -> None:
    """Print every experiment."""
    for title, heads, rows in (
        ("Table I, ours over the printed", list(ONE["rows"]), table_one()),
        ("Table II", list(ONE["rows"]), table_two()),
        ("Table III, ours over the printed", list(THREE["rows"]), table_three()),
    ):
        print(f"\n{title}\n| entry | as | {' | '.join(heads)} |\n|---|---|{'---|' * len(heads)}")
        for entry, words, figures in rows:
            print(f"| {entry} | {words} | {' | '.join(f'{f:.2f}' for f in figures)} |", flush=True)


if __name__ == "__main__":
    main()
