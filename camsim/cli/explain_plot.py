"""Plots of a capture's optics; here the MTFs and PSFs of its stages, as in the paper."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from camsim.camera.capture import Capture
    from camsim.sensor.cfa import Cfa

SIZES = {
    "mtf": (9.0, 5.4),
    "psf": (10.0, 6.6),
    "qe": (9.0, 5.4),
    "spectra": (9.0, 8.0),
    "noise": (9.0, 5.8),
    "field": (11.0, 9.0),
}
ALONG = 400
SHORTEST = 0.01  # of the light: share of short wavelengths ignored for the limits of axes


def draw(capture: Capture, kind: str, file: str, at_um: tuple[float, float] | None = None) -> bytes:
    """Return a plot as the bytes of a PNG, SVG or PDF, by the suffix of ``file``; ``kind``: a key of ``SIZES``.

    at_um : place in the frame at which a PSF is drawn; None: on the axis, with all stages
    """
    return bytes_of(figure_of(capture, kind, at_um), file)


def figure_of(capture: Capture, kind: str, at_um: tuple[float, float] | None = None) -> Figure:
    """Return the figure that ``draw`` encodes."""
    from camsim.cli.explain_field import draw_field
    from camsim.cli.explain_noise import draw_noise
    from camsim.cli.explain_psf import draw_psf
    from camsim.cli.explain_spectra import draw_efficiency, draw_spectra

    drawings: dict[str, Callable[[Figure, Capture], None]] = {
        "mtf": _draw_mtf,
        "psf": lambda figure, one: draw_psf(figure, one, _title(one), at_um, _with_crosstalk(one)),
        "qe": draw_efficiency,
        "spectra": draw_spectra,
        "noise": draw_noise,
        "field": draw_field,
    }
    figure = new_figure(*SIZES[kind])
    drawings[kind](figure, capture)
    return figure


def _with_crosstalk(capture: Capture) -> str:
    """Return a text on parts of the system besides lens, OLPF and photosite."""
    return "" if capture.camera.crosstalk is None else " with crosstalk"


def _draw_mtf(figure: Any, capture: Capture) -> None:
    from camsim.measure.theory import CameraOtf

    camera, system, theory = capture.camera, capture.camera.optics, CameraOtf.of(capture)
    axes = figure.subplots()
    last = min(2.5, max(1.05, 1.05 * system.cutoff_per_um(_shortest_nm(capture)) * camera.pitch_um))
    f, zero = np.linspace(0.0, last, ALONG), np.zeros(ALONG)
    per_um = f / camera.pitch_um
    aperture = np.abs(system.photosite.otf(per_um, zero, 0.0))
    axes.plot(f, aperture, color="grey", lw=1.0, ls=":", label="photosite")
    if system.olpf is not None:
        axes.plot(f, np.abs(system.olpf.otf(per_um, zero, 0.0)), color="grey", lw=1.0, ls="--", label="OLPF")
    slanted, crosstalk = f * np.sqrt(0.5), _with_crosstalk(capture)
    for name in camera.cfa.channels:
        lens, along = theory.at(f, zero, name, 0.0, 1.0, lens_alone=True), theory.at(f, zero, name, 0.0, 1.0)
        diagonal = theory.at(slanted, slanted, name, 0.0, 1.0)
        if lens is None or along is None or diagonal is None:
            continue
        colour = colour_of_channel(name)
        axes.plot(f, np.abs(lens), color=colour, lw=0.9, alpha=0.6, label=f"lens, {name}")
        axes.plot(f, np.abs(along), color=colour, lw=2.0, label=f"system, {name}{crosstalk}")
        axes.plot(f, np.abs(diagonal), color=colour, lw=1.2, ls="-.", label=f"system, {name}, 45°")
    for nyquist, names in nyquists(camera.cfa).items():
        axes.axvline(nyquist, color="grey", lw=0.8, ls=":")
        axes.text(
            nyquist,
            0.99,
            f"Nyquist of {', '.join(names)}",
            ha="right",
            va="top",
            rotation=90,
            fontsize=8,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
        )
    axes.set(
        xlim=(0.0, last), ylim=(0.0, 1.02), ylabel="MTF", xlabel="cycles per pitch, along x (45°: along a diagonal)"
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    axes.set_title(_title(capture), pad=18)


def _shortest_nm(capture: Capture) -> float:
    """Return the shortest wavelength with a significant share of the light."""
    samples = capture.camera.samples(capture.light)
    share = capture.camera.electrons_per_reflectance(samples, 1.0).sum(axis=0).cumsum()
    return float(samples.wavelength_nm[np.searchsorted(share, SHORTEST * share[-1])])


def _title(capture: Capture) -> str:
    """Return the title, with the pitch: the camera's name may mention another."""
    camera = capture.camera
    return f"{capture.scene_name}: {camera.name}; pitch {camera.pitch_um:g} µm, f/{camera.working_f_number:g}"


def nyquists(cfa: Cfa) -> dict[float, list[str]]:
    """Return the Nyquist frequencies, cycles per pitch, of the sensor and of each measured channel, by name.

    As in ``camsim measure mtf``: for a Bayer array G1 and G2 separately, each on its lattice.
    """
    from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL
    from camsim.measure.picture import Picture, mosaic_planes

    period = np.zeros((len(cfa.pattern), len(cfa.pattern[0])))
    found = {NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL: ["the sensor"]}
    for channel in Picture(name="", shape=period.shape, planes=mosaic_planes(period, tuple(cfa.pattern))).select("all"):
        found.setdefault(channel.nyquist_cycles_per_pixel, []).append(channel.name)
    return found
