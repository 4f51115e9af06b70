"""True error against the tolerance asked for, of both engines: ``python -m bench.convergence`` (some minutes).

Prints the figures and writes docs/convergence.svg. Truths that share nothing with camsim: reference values by adaptive
quadrature (tests/data), exact Fourier renderings of whole images (tests/truth/lattice.py), of one wavelength and of 61
added up, and a Hankel integral for discs (tests/analytic/test_discs.py).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from tests.truth.closed_forms import disc_by_frequencies
from tests.truth.lattice import white_with_a_black_polygon

ROOT = Path(__file__).parents[1]
DECADES = tuple(10.0**-digits for digits in range(2, 12))
FINEST = {"boundary": 1e-9, "fourier": 1e-11}
EVERY = 4  # of the reference values
ROWS, COLS, SIDE_PX, TURN_DEG = 48, 56, 30.0, 4.0


def square() -> np.ndarray:
    """Return the corners of a slanted square, pitches."""
    angle, half = np.deg2rad(TURN_DEG), 0.5 * SIDE_PX
    across, down = half * np.array([np.cos(angle), np.sin(angle)]), half * np.array([-np.sin(angle), np.cos(angle)])
    return np.array([-across - down, across - down, across + down, -across + down])


def reference_values() -> Callable[[str, float], float]:
    """Points of many polygons, λN from 0.08 to 20 pitches, with and without photosite and OLPF."""
    cases = json.loads((ROOT / "tests" / "data" / "oracle-values.json").read_text(encoding="utf-8"))["cases"][::EVERY]

    def error(method: str, tolerance: float) -> float:
        worst = 0.0
        for case in cases:
            points = tuple((x - case["x"], y - case["y"]) for x, y in case["polygon"])
            optics = [camsim.Airy(f_number=2.0 * case["L"]), camsim.SquarePhotosite(side_um=case["box"])]
            if case["olpf"]:
                optics.append(camsim.FourSpotOlpf(split_um=case["olpf"]))
            image = camsim.render(
                camsim.Scene(background=0.0, shapes=[camsim.Polygon(points_um=points, reflectance=1.0)]),
                optics,
                camsim.Grid(rows=1, cols=1, pitch_um=1.0),
                wavelength_nm=500.0,
                tolerance=tolerance,
                method=method,
            ).image
            worst = max(worst, abs(image[0, 0] - case["value"]))
        return worst

    return error


def slanted_square(wavelengths: int) -> Callable[[str, float], float]:
    """Every photosite of a black square on white through lens, OLPF and photosite; of 450–650 nm added up."""
    nm = np.linspace(450.0, 650.0, wavelengths) if wavelengths > 1 else np.array([550.0])
    weights = np.hanning(wavelengths + 2)[1:-1]
    weights /= weights.sum()
    truth = sum(
        w * white_with_a_black_polygon(square(), ROWS, COLS, n / 550.0, side=1.0, split=0.75)
        for w, n in zip(weights, nm, strict=True)
    )
    scene = camsim.Scene(background=1.0, shapes=[camsim.Polygon(points_um=square(), reflectance=0.0)])
    optics = [
        camsim.Airy(f_number=1e3 / 550.0),
        camsim.FourSpotOlpf(split_um=0.75),
        camsim.SquarePhotosite(side_um=1.0),
    ]

    def error(method: str, tolerance: float) -> float:
        rendering = render_channels(
            scene,
            OpticalSystem.of(optics),
            camsim.Grid(rows=ROWS, cols=COLS, pitch_um=1.0),
            response=weights[None],
            wavelength_nm=nm,
            channel=np.zeros((ROWS, COLS), np.uint8),
            tolerance=tolerance,
            method=method,
        )
        return float(np.abs(rendering.image - truth).max())

    return error


def discs() -> Callable[[str, float], float]:
    """Point samples about the rim of discs of 3 to 60 λN."""

    def error(method: str, tolerance: float) -> float:
        worst = 0.0
        for radius, lambda_n in ((3.0, 0.3), (10.0, 1.0), (60.0, 1.0)):
            for distance in radius + lambda_n * np.array([-0.5, 0.25, 0.5]):
                disc = camsim.Disc(radius_um=radius, centre_um=(distance, 0.0), reflectance=1.0)
                image = camsim.render(
                    camsim.Scene(background=0.0, shapes=[disc]),
                    [camsim.Airy(f_number=lambda_n)],
                    camsim.Grid(rows=1, cols=1, pitch_um=1.0),
                    wavelength_nm=1000.0,
                    tolerance=tolerance,
                    method=method,
                ).image
                worst = max(worst, abs(image[0, 0] - disc_by_frequencies(radius, lambda_n, distance)))
        return worst

    return error


# What makes each series, and how far its truth reaches: the exact Fourier rendering's own error is 1.4e-11.
SERIES = {
    "reference values": (reference_values, 1e-11),
    "slanted square, 550 nm": (lambda: slanted_square(1), 1e-10),
    "slanted square, 61 wavelengths": (lambda: slanted_square(61), 1e-10),
    "discs": (discs, 1e-11),
}


def main() -> None:
    """Measure, print, draw."""
    found: dict[tuple[str, str], list[tuple[float, float]]] = {}
    for name, (make, reaches) in SERIES.items():
        error = make()
        for engine, finest in FINEST.items():
            points = [(t, error(engine, t)) for t in DECADES if t >= 0.99 * max(finest, reaches)]
            found[name, engine] = points
            stated = "  ".join(f"{t:.0e}: {e:.1e}{' ABOVE' if e > t else ''}" for t, e in points)
            print(f"{name}, {engine}: {stated}", flush=True)
    draw(found)


def draw(found: dict[tuple[str, str], list[tuple[float, float]]]) -> None:
    """Write the plot."""
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams["svg.hashsalt"] = "camsim"
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    axes = figure.subplots()
    axes.loglog([1e-11, 1e-2], [1e-11, 1e-2], color="black", lw=1.0, label="error = tolerance")
    colours = dict(zip(SERIES, ("#2456a6", "#c0392b", "#1e8449", "#7d3c98"), strict=True))
    for (name, engine), points in found.items():
        tolerance, error = np.array(points).T
        style = {"marker": "o", "ls": "-"} if engine == "boundary" else {"marker": "s", "ls": "--", "mfc": "none"}
        axes.loglog(tolerance, np.maximum(error, 1e-15), color=colours[name], ms=5, label=f"{name}, {engine}", **style)
    axes.set(xlabel="tolerance asked for", ylabel="largest true error", xlim=(2e-2, 5e-12), ylim=(1e-15, 2e-2))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7, loc="lower left")
    figure.savefig(ROOT / "docs" / "convergence.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
