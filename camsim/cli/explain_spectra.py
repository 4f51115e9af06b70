"""Quantum efficiencies, and the spectra of a capture: light, surfaces, what passes, what each channel gets of white."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli.plot import colour_of_channel
from camsim.core.arrays import F64, distinct
from camsim.spectra.curve import Curve, Spectrum, spectrum_at

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

_POINTS = 800
_MOST_TOGETHER = 8  # surfaces on one pair of axes
_COLUMNS, _MOST_ROWS = 8, 8  # of small axes, one for each surface


def nodes_nm(capture: Capture, curves: Iterable[Spectrum], ends_nm: tuple[float, float]) -> F64:
    """Return the wavelengths at which curves are drawn: evenly spaced ones, and the kinks of the curves."""
    one = [nm for curve in curves if isinstance(curve, Curve) for nm in curve.wavelength_nm]
    low_nm, high_nm = ends_nm
    inside = [nm for nm in one if low_nm <= nm <= high_nm]
    return distinct(np.concatenate([np.linspace(low_nm, high_nm, _POINTS), inside]))


def draw_efficiency(figure: Any, capture: Capture) -> None:
    """Draw each channel's electrons per photon: of the sensor alone, and with other transmissions and crosstalk."""
    camera = capture.camera
    efficiency = camera.quantum_efficiency.select(camera.cfa.channels)
    curves = [curve for _, curve in efficiency.curves]
    passes = [spectrum for _, spectrum in camera.dimmed_by(capture.light)]
    ends = min(c.wavelength_nm[0] for c in curves), max(c.wavelength_nm[-1] for c in curves)
    at_nm = nodes_nm(capture, (*curves, *passes), ends)
    through = np.prod([np.ones_like(at_nm), *(spectrum_at(part, at_nm) for part in passes)], axis=0)
    bare = efficiency.at(at_nm)
    changed = _changed(capture, dimmed=bool(np.any(through < 1.0)))
    axes = figure.subplots()
    for name, values, seen in zip(camera.cfa.channels, bare, camera.after_crosstalk(bare * through), strict=True):
        colour = colour_of_channel(name)
        axes.plot(at_nm, values, color=colour, lw=1.6, label=name)
        if changed:
            axes.plot(at_nm, seen, color=colour, lw=1.0, ls="--", label=f"{name}, {changed}")
    low_nm, high_nm = capture.light.ends_nm
    shone = f"the light, {capture.light.name}"
    if high_nm > low_nm:
        axes.axvspan(low_nm, high_nm, color="gold", alpha=0.12, label=shone)
    else:
        axes.axvline(low_nm, color="goldenrod", lw=1.2, label=shone)
    axes.set(xlabel="wavelength, nm", ylabel="electrons per photon", ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    axes.set_title(f"{camera.name}: quantum efficiency")


def _changed(capture: Capture, *, dimmed: bool) -> str:
    """Return a text on the modifications of a channel's efficiency; empty if none."""
    parts = ["filters"] * bool(capture.camera.filters) + ["the lens"] * (capture.light.at != "sensor")
    behind = [f"behind {' and '.join(parts)}"] * dimmed
    return ", ".join([*behind, *["after crosstalk"] * (capture.camera.crosstalk is not None)])


def _name_of(surface: Spectrum) -> str:
    return (surface.name or "a table") if isinstance(surface, Curve) else f"{surface:g}"


def draw_spectra(figure: Any, capture: Capture) -> None:
    """Draw the light, reflectances, transmissions, and each channel's response to white."""
    camera, light = capture.camera, capture.light
    surfaces = dict.fromkeys(capture.scene.spectra)
    passes = camera.dimmed_by(light)
    low_nm, high_nm = light.ends_nm
    one_line = light.is_one_line
    ends = (low_nm - 50.0, high_nm + 50.0) if one_line else (low_nm, high_nm)
    at_nm = nodes_nm(capture, (*surfaces, *(spectrum for _, spectrum in passes)), ends)
    many = len(surfaces) > _MOST_TOGETHER
    rows = min(-(-len(surfaces) // _COLUMNS), _MOST_ROWS) if many else 0
    grid = figure.add_gridspec(3 + rows, _COLUMNS, height_ratios=[2.0, 2.0, 2.0, *[1.0] * rows])
    top = figure.add_subplot(grid[0, :])
    middle, below = (figure.add_subplot(grid[k, :], sharex=top) for k in (1, 2))
    samples = camera.samples(light, surfaces)
    white = camera.after_crosstalk(camera.electrons_per_reflectance(samples, capture.time_s))
    if one_line:
        top.vlines(low_nm, 0.0, light.irradiance_at(np.array([low_nm])), color="goldenrod", lw=2.0)
    else:
        top.fill_between(at_nm, light.irradiance_at(at_nm), color="goldenrod", alpha=0.4)
    small = [
        figure.add_subplot(grid[3 + k // _COLUMNS, k % _COLUMNS]) for k in range(min(len(surfaces), rows * _COLUMNS))
    ]
    for axes, surface in zip(small, surfaces, strict=False):
        axes.plot(at_nm, spectrum_at(surface, at_nm), color="black", lw=1.0)
        axes.set(xlim=ends, ylim=(0.0, 1.0), xticks=np.linspace(*ends, 3).round(-1), yticks=(0.0, 0.5, 1.0))
        axes.set_title(_name_of(surface).rpartition("/")[2], fontsize=7, pad=2)
        axes.tick_params(labelsize=5, labelleft=axes.get_subplotspec().is_first_col())
        axes.grid(alpha=0.3)
    for surface in () if many else surfaces:
        middle.plot(at_nm, spectrum_at(surface, at_nm), lw=1.2, label=f"surface, {_name_of(surface)}")
    for name, part in passes:
        middle.plot(at_nm, spectrum_at(part, at_nm), lw=1.2, ls="--", label=f"{name}, transmission")
    for name, electrons in zip(camera.cfa.channels, white, strict=True):
        colour = colour_of_channel(name)
        label = f"{name}, {electrons.sum():.4g} e⁻ in all"
        if one_line:
            below.plot([low_nm], electrons[:1], "o", color=colour, label=label)
        else:
            below.plot(samples.wavelength_nm, electrons / samples.weight_nm, color=colour, lw=1.4, label=label)
    top.set_ylabel("W/m²" if one_line else "W/m² per nm")
    top.set_title(f"{capture.scene_name}: {light.name}, {light.level} on the {light.at}", fontsize=10)
    middle.set(ylabel="fraction", ylim=(0.0, 1.05))
    if small:
        left_out = f"; {len(surfaces) - len(small)} more are not drawn" if len(surfaces) > len(small) else ""
        below.set_title(f"e⁻ of each channel; below: reflectance of each surface over nm{left_out}", fontsize=9)
    below.set(
        ylabel="e⁻ of white" if one_line else "e⁻ per nm of white", xlabel="wavelength, nm", xlim=ends, ylim=(0.0, None)
    )
    for axes in (top, middle, below):
        axes.grid(alpha=0.3)
    for axes in (middle, below):
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize=7, loc="upper right")
