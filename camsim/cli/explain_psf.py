"""Plots of PSFs: of the lens, of OLPF and photosite, and of all stages; or of the lens at a place."""

from __future__ import annotations

import dataclasses
import math
import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from camsim.cli.explain_field import field_lens
from camsim.cli.plot import colour_of_channel
from camsim.core.arrays import C128, F64
from camsim.errors import UnsupportedError
from camsim.optics import Airy, AnnularAiry, FieldLens, Wavefront

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

FOOTPRINT = "photosite"
LEAST_PITCHES, MOST_PITCHES = 4.0, 128.0  # displayed half width
DISPLAYED = 0.8  # of the lens's light
PERIODS = 8.0  # period of the transform in displayed half widths, with little wrap-around
LEAST_CELLS, MOST_CELLS = 1024, 4096  # of a period
FAINTEST = 1e-4  # of the brightest

Transfer = Callable[[F64, F64], "F64 | C128 | None"]


@dataclass(frozen=True, kw_only=True)
class _Window:
    """The displayed window of PSFs: half width ``pitches``, from ``cells`` of a period."""

    pitches: float
    cells: int
    pitch_um: float

    @property
    def step_pitch(self) -> float:
        return PERIODS * self.pitches / self.cells

    def pattern(self, transfer: Transfer, highest: float = math.inf) -> F64:
        """Return the PSF around its centre, per µm² for unit power; ``highest``: the cut-off in cycles per pitch."""
        fx, fy = np.meshgrid(
            scipy.fft.rfftfreq(self.cells, self.step_pitch), scipy.fft.fftfreq(self.cells, self.step_pitch)
        )
        passes = np.hypot(fx, fy) < highest
        otf = np.zeros(fx.shape, complex)
        otf[passes] = transfer(fx[passes], fy[passes])
        pattern = scipy.fft.fftshift(scipy.fft.irfft2(otf, (self.cells, self.cells)))
        half = round(self.pitches / self.step_pitch)
        middle = slice(self.cells // 2 - half, self.cells // 2 + half + 1)
        displayed: F64 = pattern[middle, middle] / (self.step_pitch * self.pitch_um) ** 2
        return displayed


def draw_psf(figure: Any, capture: Capture, title: str, at_um: tuple[float, float] | None, crosstalk: str) -> None:
    """Draw PSFs side by side, and below each its profiles along x and along a diagonal, in µm.

    at_um     : place at which a field lens's PSF is drawn, in every channel; None: PSFs on the axis, of the lens, of
                OLPF and photosite, and of all stages
    crosstalk : remark on crosstalk that the plot carries; empty without crosstalk
    """
    from camsim.measure.theory import CameraOtf

    camera, theory = capture.camera, CameraOtf.of(capture)
    place_um = at_um or (0.0, 0.0)
    if at_um is not None and math.hypot(*at_um) > (rim_um := field_lens(capture).height_um[-1]):
        raise UnsupportedError(
            f"lies {math.hypot(*at_um):g} µm from the axis; the lens's image circle ends at {rim_um:g}", key="--at"
        )
    perfect = _perfect(camera.lens)
    ideal = None if perfect is None else dataclasses.replace(theory, camera=camera.replace(lens=perfect))
    names = camera.cfa.channels
    if at_um is None:
        names = (names[int(np.argmax(camera.diffuser_electrons(capture.light, 1.0)))],)

    def of_lens(name: str, whose: CameraOtf = theory) -> Transfer:
        return lambda fx, fy: whose.at(fx, fy, name, 0.0, 1.0, place_um=place_um, lens_alone=True)

    highest = camera.optics.cutoff_per_um(float(capture.samples.wavelength_nm[0])) * camera.pitch_um
    window = _window(of_lens(names[0]), highest, camera.pitch_um)
    patterns: dict[str, tuple[F64, str]] = {}
    for name in names:
        of_channel = window.pattern(of_lens(name), highest)
        stated = f"lens, {name}"
        if ideal is not None:
            stated += f"; Strehl ratio {_peak(of_channel) / _peak(window.pattern(of_lens(name, ideal), highest)):.3f}"
        patterns[stated] = of_channel, colour_of_channel(name) if at_um is not None else "black"
    if at_um is None:
        # A photosite's OTF has no cut-off; a slight blur avoids ringing by truncation.
        blur = -2.0 * (np.pi * 1.2 * window.step_pitch) ** 2
        system, pitch_um = camera.optics, camera.pitch_um
        footprint = window.pattern(
            lambda fx, fy: system.footprint_otf(fx / pitch_um, fy / pitch_um) * np.exp(blur * (fx**2 + fy**2))
        )
        whole = window.pattern(lambda fx, fy: theory.at(fx, fy, names[0], 0.0, 1.0), highest)
        patterns[FOOTPRINT if system.olpf is None else "OLPF ⊗ photosite"] = footprint, "black"
        patterns[f"system, {names[0]}{crosstalk}"] = whole, "black"
    figure.set_figwidth(max(4.5, 3.3 * len(patterns)))
    pictures, slices = figure.subplots(2, len(patterns), height_ratios=[3, 2], squeeze=False)
    for above, below, (stated, (pattern, colour)) in zip(pictures, slices, patterns.items(), strict=True):
        _show(figure, above, below, pattern, window)
        above.set_title(stated, fontsize=10, color=colour)
    place = "" if at_um is None else f"; at ({at_um[0]:g}, {at_um[1]:g}) µm"
    figure.suptitle(textwrap.fill(f"{title}{place}", 20 + 25 * len(patterns)))


def _window(lens: Transfer, highest: float, pitch_um: float) -> _Window:
    """Return the smallest window that contains most of a lens's light."""
    pitches = LEAST_PITCHES
    while True:
        cells = 2 ** math.ceil(math.log2(2.0 * highest * PERIODS * pitches))
        window = _Window(pitches=pitches, cells=min(max(cells, LEAST_CELLS), MOST_CELLS), pitch_um=pitch_um)
        light = window.pattern(lens, highest).sum() * (window.step_pitch * pitch_um) ** 2
        if light >= DISPLAYED or pitches >= MOST_PITCHES:
            return window
        pitches *= 2.0


def _perfect(lens: Any) -> Any:
    """Return the lens without its aberrations; None if not defined by its pupil."""
    if type(lens) in (Airy, AnnularAiry):
        return lens
    if type(lens) is Wavefront:
        return dataclasses.replace(lens, zernike_waves=(), defocus_um=0.0)
    if type(lens) is FieldLens:
        return Airy(f_number=lens.f_number, transmission=lens.transmission)
    return None


def _peak(pattern: F64) -> float:
    """Return the largest value, by parabolas along x and y through the largest sample and its neighbours."""
    row, col = np.unravel_index(int(np.argmax(pattern)), pattern.shape)
    peak = middle = float(pattern[row, col])
    for line, place in ((pattern[row], col), (pattern[:, col], row)):
        if 0 < place < line.size - 1:
            before, after = float(line[place - 1]), float(line[place + 1])
            bend = before - 2.0 * middle + after
            peak -= 0.125 * (after - before) ** 2 / bend if bend < 0.0 else 0.0
    return peak


def _show(figure: Any, above: Any, below: Any, pattern: F64, window: _Window) -> None:
    half_um = window.pitches * window.pitch_um
    half, brightest = pattern.shape[0] // 2, pattern.max()
    extent = (-half_um, half_um, half_um, -half_um)
    displayed = np.sqrt(np.maximum(pattern, 0.0) / brightest)
    image = above.imshow(displayed, extent=extent, cmap="magma", interpolation="nearest", vmin=0.0, vmax=1.0)
    above.set(xlabel="x, µm", ylabel="y (down), µm")
    pitch_um = window.pitch_um
    above.add_patch(_square(pitch_um))
    figure.colorbar(image, ax=above, shrink=0.7, label="root of relative irradiance")
    along_um = np.arange(-half, half + 1) * window.step_pitch * pitch_um
    below.semilogy(along_um, np.maximum(pattern[half] / brightest, 1e-12), color="black", lw=1.0, label="along x")
    diagonal = np.maximum(np.diagonal(pattern) / brightest, 1e-12)
    below.semilogy(along_um * math.sqrt(2.0), diagonal, color="grey", lw=0.8, ls="--", label="along a diagonal")
    below.axvspan(-0.5 * pitch_um, 0.5 * pitch_um, color="#2a7", alpha=0.15, lw=0.0, label=f"pitch, {pitch_um:g} µm")
    below.set(
        xlim=(-half_um, half_um),
        ylim=(FAINTEST, 1.5),
        xlabel="from the middle, µm",
        ylabel=f"irradiance / {brightest:.3g} per µm²",
    )
    below.grid(alpha=0.3)
    below.legend(fontsize=7, loc="lower center")


def _square(side_um: float) -> Any:
    from matplotlib.patches import Rectangle

    place = (-0.5 * side_um, -0.5 * side_um)
    return Rectangle(place, side_um, side_um, fill=False, edgecolor="#8fd", lw=0.8)
