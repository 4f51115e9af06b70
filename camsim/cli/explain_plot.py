"""Pictures of what a capture computes; here the transfers and patterns of its stages, as in the paper."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.arrays import F64
from camsim.cli.plot import colour_of_channel

if TYPE_CHECKING:
    from camsim.exposing import Capture
    from camsim.sensor.cfa import Cfa

SIZES = {
    "mtf": (9.0, 5.4),
    "psf": (10.0, 6.6),
    "qe": (9.0, 5.4),
    "spectra": (9.0, 8.0),
    "noise": (9.0, 5.8),
    "field": (11.0, 9.0),
}
WAVELENGTHS = 24  # of a curve or pattern, at the most
ALONG = 400
FOOTPRINT = "photosite"
PITCHES, PERIOD, CELLS = 4.0, 32.0, 1024  # what is shown to either side; a period that hardly wraps, and its samples


def draw(capture: Capture, kind: str, suffix: str, at_um: tuple[float, float] | None = None) -> bytes:
    """Return a picture, one of ``SIZES``, as bytes of a PNG, SVG or PDF.

    at_um : of a pattern, where in the frame; None: on the axis, with all stages
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.figure import Figure

    from camsim.cli.explain_field import draw_at, draw_field
    from camsim.cli.explain_noise import draw_noise
    from camsim.cli.explain_spectra import draw_efficiency, draw_spectra

    drawings = {
        "mtf": _draw_mtf,
        "psf": _draw_psf,
        "qe": draw_efficiency,
        "spectra": draw_spectra,
        "noise": draw_noise,
        "field": draw_field,
    }
    figure = Figure(figsize=SIZES[kind], layout="constrained")
    if at_um is None:
        drawings[kind](figure, capture)
    else:
        draw_at(figure, capture, at_um, [shares_of(capture, k) for k in range(len(capture.camera.cfa.channels))])
    out = io.BytesIO()
    figure.savefig(out, format=suffix, dpi=130, metadata={"Date": None} if suffix == "svg" else None)
    return out.getvalue()


def shares_of(capture: Capture, channel: int) -> tuple[F64, F64]:
    """Return wavelengths (nm) and the share that each has in what a channel sees of a white surface.

    Each stands for a stretch of the spectrum: its mean wavelength, and all of its light.
    """
    samples = capture.camera.samples(capture.light)
    response = capture.camera.electrons_per_reflectance(samples, 1.0)[channel]
    used = np.flatnonzero(response)
    first = np.arange(0, used.size, max(1, -(-used.size // WAVELENGTHS)))
    if not used.size:
        return np.empty(0), np.empty(0)
    light, moment = (np.add.reduceat(w[used], first) for w in (response, response * samples.wavelength_nm))
    shares: F64 = light / light.sum()
    return moment / light, shares


def _lens(capture: Capture, channel: int, fx: F64, fy: F64) -> Any:
    system = capture.camera.optics
    wavelength_nm, shares = shares_of(capture, channel)
    return sum(s * system.point_otf(fx, fy, float(w)) for w, s in zip(wavelength_nm, shares, strict=True))


def _system(capture: Capture, channel: int, fx: F64, fy: F64, lens: Any) -> Any:
    """Return the transfer of all stages up to the electrons; ``lens`` is the lens's own in the channel's own light."""
    camera = capture.camera
    if camera.crosstalk is None:
        return lens * camera.optics.footprint_otf(fx, fy)
    from camsim.measure.theory import CameraOtf

    pitch_um = camera.pitch_um
    return CameraOtf.of(capture).at(fx * pitch_um, fy * pitch_um, camera.cfa.channels[channel], 0.0, 1.0)


def _with_crosstalk(capture: Capture) -> str:
    """Say of the system what else than lens, OLPF and photosite is in it."""
    return "" if capture.camera.crosstalk is None else " with crosstalk"


def _draw_mtf(figure: Any, capture: Capture) -> None:
    camera, system = capture.camera, capture.camera.optics
    axes = figure.subplots()
    shortest = min(shares_of(capture, k)[0].min(initial=1e9) for k in range(len(camera.cfa.channels)))
    last = min(2.5, max(1.05, 1.05 * system.cutoff_per_um(float(shortest)) * camera.pitch_um))
    f = np.linspace(0.0, last, ALONG)
    per_um, zero = f / camera.pitch_um, np.zeros(ALONG)
    aperture = np.abs(system.photosite.otf(per_um, zero, 0.0))
    axes.plot(f, aperture, color="grey", lw=1.0, ls=":", label="photosite")
    if system.olpf is not None:
        axes.plot(f, np.abs(system.olpf.otf(per_um, zero, 0.0)), color="grey", lw=1.0, ls="--", label="OLPF")
    slanted, crosstalk = per_um * np.sqrt(0.5), _with_crosstalk(capture)
    for k, name in enumerate(camera.cfa.channels):
        if not shares_of(capture, k)[0].size:
            continue
        colour = colour_of_channel(name)
        lens = _lens(capture, k, per_um, zero)
        axes.plot(f, np.abs(lens), color=colour, lw=0.9, alpha=0.6, label=f"lens, {name}")
        along = _system(capture, k, per_um, zero, lens)
        axes.plot(f, np.abs(along), color=colour, lw=2.0, label=f"system, {name}{crosstalk}")
        diagonal = _system(capture, k, slanted, slanted, _lens(capture, k, slanted, slanted))
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


def _title(capture: Capture) -> str:
    """Name the pitch too: the camera's name is a text, and may speak of another."""
    camera = capture.camera
    return f"{capture.scene_name}: {camera.name}; pitch {camera.pitch_um:g} µm, f/{camera.working_f_number:g}"


def nyquists(cfa: Cfa) -> dict[float, list[str]]:
    """Return the Nyquist frequencies, cycles per pitch, and whose: the sensor's, and each channel's that is measured.

    ``camsim measure mtf`` has the same: of a Bayer array G1 and G2 apart, on a lattice each.
    """
    from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL
    from camsim.measure.picture import Picture, mosaic_planes

    period = np.zeros((len(cfa.pattern), len(cfa.pattern[0])))
    found = {NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL: ["the sensor"]}
    for channel in Picture(name="", shape=period.shape, planes=mosaic_planes(period, cfa.pattern)).select("all"):
        found.setdefault(channel.nyquist_cycles_per_pixel, []).append(channel.name)
    return found


def _draw_psf(figure: Any, capture: Capture) -> None:
    camera, system = capture.camera, capture.camera.optics
    channel = int(np.argmax(camera.diffuser_electrons(capture.light, 1.0)))
    name = camera.cfa.channels[channel]
    step = PERIOD / CELLS
    f = np.fft.fftfreq(CELLS, step) / camera.pitch_um
    fx, fy = np.meshgrid(f, f)
    lens = _lens(capture, channel, fx, fy)
    # A photosite's transfer never ends; a little blur keeps what the samples cut off from ringing.
    blur = np.exp(-2.0 * np.pi**2 * (1.2 * step * camera.pitch_um) ** 2 * (fx**2 + fy**2))
    footprint = system.footprint_otf(fx, fy)
    whole = _system(capture, channel, fx, fy, lens)
    parts = {f"lens, {name}": lens, FOOTPRINT: footprint * blur, f"system, {name}{_with_crosstalk(capture)}": whole}
    half = round(PITCHES / step)
    patterns = {title: _pattern(otf, half) for title, otf in parts.items()}
    pictures, slices = figure.subplots(2, 3, height_ratios=[3, 2])
    along = np.arange(-half, half + 1) * step
    ticks = np.arange(-PITCHES, PITCHES + 1.0)
    for above, below, (title, pattern) in zip(pictures, slices, patterns.items(), strict=True):
        brightest = pattern.max()
        shown = np.sqrt(np.maximum(pattern, 0.0) / brightest)
        image = above.imshow(
            shown, extent=(-PITCHES, PITCHES, PITCHES, -PITCHES), cmap="magma", interpolation="nearest"
        )
        above.set_title(title if system.olpf is None or title != FOOTPRINT else "OLPF ⊗ photosite", fontsize=10)
        above.set(xticks=ticks, yticks=ticks, xlabel="x, pitches", ylabel="y (down), pitches")
        figure.colorbar(image, ax=above, shrink=0.7, label="root of relative irradiance")
        below.semilogy(along, np.maximum(pattern[half] / brightest, 1e-12), color="black", lw=1.0, label="along x")
        diagonal = np.maximum(np.diagonal(pattern) / brightest, 1e-12)
        below.semilogy(along * np.sqrt(2.0), diagonal, color="grey", lw=0.8, ls="--", label="along a diagonal")
        below.set(
            xlim=(-PITCHES, PITCHES),
            ylim=(1e-4, 1.5),
            xticks=ticks,
            xlabel="from the middle, pitches",
            ylabel="relative irradiance",
        )
        below.grid(alpha=0.3)
    slices[0].legend(fontsize=7)
    figure.suptitle(_title(capture))


def _pattern(otf: F64, half: int) -> F64:
    """Return the relative irradiance on ``half`` samples to either side of the middle."""
    pattern = np.fft.fftshift(np.fft.ifft2(otf).real)
    middle = slice(CELLS // 2 - half, CELLS // 2 + half + 1)
    shown: F64 = pattern[middle, middle]
    return shown
