"""The paper's Table II: MTF50 measured on edges of known blur, by the method that rendered them.

A Gaussian lens of MTF50 0.10–0.40 cycles/px on point photosites, an edge of 4°, 25 sub-pixel shifts, images rounded to
16 bits. Each entry is the mean |error| of MTF50 in per cent. ``closed form`` is the error function itself, made by no
renderer: what the measurement alone is off by.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence

import numpy as np
from scipy import special

from bench.paper.cases import MTF50S, SAMPLED, SHIFTS, TURN_DEG, WAVELENGTH_NM, Setting
from bench.results import Results
from camsim.core.arrays import F64
from camsim.measure import Plane, Roi, measure_edge
from camsim.optics import Gaussian, SquarePhotosite
from camsim.rendering import Grid, render
from camsim.scene import Rectangle, Scene

CLOSED_FORM = "closed form"
ROWS, COLS, DARK, BRIGHT = 96, 80, 0.1, 0.9
FAR_PX = 4000.0
QUICK_SHIFTS, QUICK_MTF50S = 1, (0.10, 0.25, 0.40)


def measure_table(results: Results, *, methods: Sequence[str], quick: bool = False) -> None:
    """Write one line per method."""
    shifts = QUICK_SHIFTS if quick else SHIFTS
    mtf50s = QUICK_MTF50S if quick else MTF50S
    places = (np.arange(shifts) + 0.5) / shifts - 0.5
    settings = [
        Setting(method=method, samples=samples)
        for method in methods
        if method in ("boundary", *SAMPLED) and method != "area"
        for samples in SAMPLED.get(method, (None,))[:2]
    ]
    for setting in (*settings, Setting(method=CLOSED_FORM)):
        began, errors = time.perf_counter(), {}
        for mtf50 in mtf50s:
            mean = float(np.mean([error_percent(_image(setting, mtf50, place), mtf50) for place in places]))
            # What never falls to one half has no MTF50: edges on whole pixels are steps.
            errors[f"{mtf50:.2f}"] = mean if math.isfinite(mean) else None
        results.add(
            "table2",
            method=setting.method,
            label=setting.label,
            shifts=shifts,
            error_percent=errors,
            mean_percent=_mean([e for e in errors.values() if e is not None], len(errors)),
            seconds=time.perf_counter() - began,
        )


def error_percent(image: F64, mtf50: float) -> float:
    """Return by how much MTF50 of a 16-bit image of the edge is off, per cent."""
    codes = np.rint(65535.0 * np.clip(image, 0.0, 1.0)).astype(np.uint16)
    edge = measure_edge(Plane(name="Y", samples=codes), Roi(0, 0, ROWS, COLS))
    return 100.0 * abs(edge.figures.mtf50_cycles_per_pixel / mtf50 - 1.0)


def closed_form(mtf50: float, shift_px: float) -> F64:
    """Return the edge (rows, cols) as the error function says, dark on the left."""
    sigma, turn = math.sqrt(math.log(2.0) / 2.0) / (math.pi * mtf50), math.radians(TURN_DEG)
    x, y = np.meshgrid(np.arange(COLS) + 0.5 - 0.5 * COLS, np.arange(ROWS) + 0.5 - 0.5 * ROWS)
    across = x * math.cos(turn) + y * math.sin(turn) - shift_px
    edge: F64 = DARK + (BRIGHT - DARK) * special.ndtr(across / sigma)
    return edge


def _image(setting: Setting, mtf50: float, shift_px: float) -> F64:
    if setting.method == CLOSED_FORM:
        return closed_form(mtf50, shift_px)
    turn, reach = math.radians(TURN_DEG), 0.5 * FAR_PX + shift_px
    half_plane = Rectangle(
        width_um=FAR_PX,
        height_um=2.0 * FAR_PX,
        rotate_deg=TURN_DEG,
        centre_um=(reach * math.cos(turn), reach * math.sin(turn)),
        reflectance=BRIGHT,
    )
    return render(
        Scene(background=DARK, shapes=[half_plane]),
        [Gaussian.from_mtf50(mtf50), SquarePhotosite(side_um=0.0)],
        Grid(rows=ROWS, cols=COLS, pitch_um=1.0),
        wavelength_nm=WAVELENGTH_NM,
        method=setting.method,
        samples=setting.samples,
    ).image


def _mean(found: Sequence[float], wanted: int) -> float | None:
    return float(np.mean(found)) if len(found) == wanted else None
