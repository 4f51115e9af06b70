"""Plots of a field-varying lens: properties along a radius, and its PSF at a place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.core.arrays import distinct
from camsim.errors import UnsupportedError
from camsim.optics import FieldLens
from camsim.optics.placed import PlacedLens
from camsim.optics.sampled import sampled_otf

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

PLACES = 17  # along a radius
LINE_PAIRS_PER_MM = (10.0, 20.0, 40.0)
DISTORTIONS = 200  # heights of a smooth curve
HALF, SAMPLES = 12.0, 241  # of a PSF: half width in λN, and samples
PRECISION = 1e-6
WAVELENGTHS = 3  # of curves


def field_lens(capture: Capture) -> FieldLens:
    """Return the capture's lens; raises UnsupportedError unless it is field-varying."""
    lens = capture.camera.optics.lens
    if not isinstance(lens, FieldLens) or not lens.height_um:
        raise UnsupportedError(
            f"the lens is {type(lens).__name__}, the same all over the frame; a field lens given by height_um is drawn",
            key="--plot",
        )
    return lens


def draw_field(figure: Any, capture: Capture) -> None:
    """Draw RMS wavefront, MTF, distortion, lateral colour and illumination over the image height, and PSFs."""
    lens = field_lens(capture)
    heights_um = np.linspace(0.0, lens.height_um[-1], PLACES)
    heights_mm, known = heights_um / 1e3, np.array(lens.wavelength_nm)
    picked = distinct(np.linspace(0, known.size - 1, WAVELENGTHS).round().astype(int))
    middle_nm = float(known[known.size // 2])
    placed = [lens.at(float(h), 0.0) for h in heights_um]
    grid = figure.add_gridspec(3, 6)
    waves, mtf = figure.add_subplot(grid[0, :3]), figure.add_subplot(grid[0, 3:])
    for nm in known[picked].tolist():
        waves.plot(heights_mm, [one.waves_rms(nm) for one in placed], label=f"{nm:g} nm")
    waves.set(ylabel="wavefront, waves rms", ylim=(0.0, None))
    waves.legend(fontsize=7)
    for k, pairs in enumerate(LINE_PAIRS_PER_MM):
        f = np.array([pairs / 1e3])
        for style, name, fx, fy in (("-", "tangential", f, 0.0 * f), ("--", "sagittal", 0.0 * f, f)):
            values = [abs(complex(sampled_otf(one, fx, fy, middle_nm)[0])) for one in placed]
            mtf.plot(heights_mm, values, style, color=f"C{k}", label=f"{pairs:g} lp/mm, {name}")
    mtf.set(ylabel=f"MTF of the lens, {middle_nm:g} nm", ylim=(0.0, 1.02))
    mtf.legend(fontsize=6)
    distortion, colour, light = (figure.add_subplot(grid[1, 2 * k : 2 * k + 2]) for k in range(3))
    fine_um = np.linspace(0.0, lens.height_um[-1], DISTORTIONS)[1:]
    moved = np.zeros_like(fine_um)
    if lens.distorts:
        moved = lens.distorted(np.stack([fine_um, 0.0 * fine_um], axis=1))[:, 0] / fine_um - 1.0
    distortion.plot(fine_um / 1e3, moved)
    distortion.set(ylabel="distortion, fraction")
    for k in picked.tolist():
        shift = lens.lateral_colour_um[k] if lens.lateral_colour_um else [0.0] * len(lens.height_um)
        colour.plot(np.array(lens.height_um) / 1e3, shift, label=f"{known[k]:g} nm")
    colour.set(ylabel="lateral colour, µm")
    light.plot(fine_um / 1e3, lens.illumination(fine_um))
    light.set(ylabel="relative illumination", ylim=(0.0, 1.05))
    for axes in (waves, mtf, distortion, colour, light):
        axes.grid(alpha=0.3)
        axes.set(xlabel="from the axis, mm", xlim=(0.0, heights_mm[-1]))
    row = [figure.add_subplot(grid[2, k]) for k in range(6)]
    for axes, share in zip(row, np.linspace(0.0, 1.0, len(row)).tolist(), strict=True):
        height_um = share * lens.height_um[-1]
        image = _pattern(axes, lens.at(height_um, 0.0), middle_nm, f"{height_um / 1e3:.3g} mm")
    row[0].set_ylabel("y (down), µm", fontsize=7)
    figure.colorbar(image, ax=row, location="bottom", aspect=60, label="root of relative irradiance")
    figure.suptitle(f"{capture.scene_name}: f/{lens.f_number:g}; patterns of {middle_nm:g} nm")


def _pattern(axes: Any, placed: PlacedLens, wavelength_nm: float, place: str) -> Any:
    """Draw the PSF at a place, and its Strehl ratio: its largest value over that of a lens without aberrations."""
    blur_um = placed.blur_um(wavelength_nm)
    axis_um = np.linspace(-HALF * blur_um, HALF * blur_um, SAMPLES)
    pattern = placed.point_spread_on(axis_um, axis_um, wavelength_nm, PRECISION)
    strehl = float(pattern.max()) / (0.25 * math.pi / blur_um**2)
    extent = (axis_um[0], axis_um[-1], axis_um[-1], axis_um[0])
    axes.set_title(f"{place}, Strehl {strehl:.2g}", fontsize=7)
    axes.set_xlabel("x, µm", fontsize=7)
    axes.tick_params(labelsize=6)
    displayed = np.sqrt(pattern / pattern.max())
    return axes.imshow(displayed, extent=extent, cmap="magma", interpolation="nearest", vmin=0.0, vmax=1.0)
