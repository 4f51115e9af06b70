"""The noise of a capture by its sources, against the signal."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli.plot import colour_of_channel
from camsim.core.arrays import F64
from camsim.spectra.curve import spectrum_at

if TYPE_CHECKING:
    from camsim.camera.capture import Capture

_POINTS = 200
_LEAST_PART = 0.01  # of the total noise: smaller parts are not drawn
_FAINTEST_E = 0.1
"""The left end of the axis: below one electron, where faint scenes and dark current lie."""


def noise_budget(capture: Capture, signal_e: F64) -> dict[str, F64]:
    """Return the standard deviation that each source of noise has at a signal, both in electrons.

    For a frame: both temporal noise and fixed patterns. Their squares add up to the frame's, below saturation of well
    or converter. Crosstalk averages PRNU; other stages that are not noise (blooming, non-linearity, defects) are left
    out.
    """
    camera, even = capture.camera, np.ones_like(signal_e)
    electrons_per_dn = camera.converter.electrons_per_dn_at(capture.exposure.iso)
    dark, dark_e = camera.dark_current, capture.dark_e
    found: dict[str, F64] = {}
    for stage in capture.electronics:
        name = type(stage).__name__
        if stage is camera.shot_noise:
            found["photons"] = np.sqrt(signal_e)
            found["dark current"] = math.sqrt(dark_e) * even
        elif dark is not None and stage is dark:
            found["dark current's unevenness"] = dark.nonuniformity * dark_e * even
        elif stage is camera.prnu:
            found[name] = camera.prnu_on_grey * signal_e
        elif camera.offset_map is not None and stage is camera.offset_map:
            found[name] = camera.offset_map.spread_e(electrons_per_dn) * even
        elif constant := stage.dark_noise_e(electrons_per_dn) or getattr(stage, "sigma_e", 0.0):
            found[name] = constant * even
    steps_dn = camera.converter.step_dn(camera.converter.black_level_dn + signal_e / electrons_per_dn)
    found["rounding"] = electrons_per_dn / math.sqrt(12.0) * steps_dn
    return {name: values for name, values in found.items() if np.any(values > 0.0)}


def background_e(capture: Capture) -> F64:
    """Return (channels,) the mean electrons of the background in photosites on the axis."""
    camera, samples = capture.camera, capture.samples
    background = spectrum_at(capture.scene.background, samples.wavelength_nm)
    image_e_per_j_m2 = (camera.image_per_reflectance(samples) * background).sum(axis=1)
    return camera.after_crosstalk(capture.radiant_exposure_j_per_m2 * image_e_per_j_m2 + capture.veil_e)


def _in_words(name: str) -> str:
    """Return the common name of a stage's class: ReadNoise is read noise, Prnu is PRNU."""
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return words.upper() if words in ("Prnu", "Dsnu") else words[:1].lower() + words[1:].lower()


def draw_noise(figure: Any, capture: Capture) -> None:
    """Draw the noise of each source against the signal, and mark the scene's surfaces."""
    camera, iso = capture.camera, capture.exposure.iso
    saturation_e = camera.charge_at_e(1.0, iso)
    signal_e = np.geomspace(_FAINTEST_E, saturation_e, _POINTS)
    budget = noise_budget(capture, signal_e)
    total_e = np.sqrt(sum(values**2 for values in budget.values()))
    axes = figure.subplots()
    for name, values in budget.items():
        axes.loglog(signal_e, values, lw=1.1, label=_in_words(name))
    axes.loglog(signal_e, total_e, color="black", lw=2.0, label="all of a frame")
    axes.axvline(saturation_e, color="grey", lw=0.9, ls=":")
    words = {"ha": "right", "va": "top", "rotation": 90, "fontsize": 8}
    axes.annotate("white ", (saturation_e, 1.0), xycoords=("data", "axes fraction"), **words)
    for name, electrons in zip(camera.cfa.channels, background_e(capture), strict=True):
        if electrons >= _FAINTEST_E:
            axes.axvline(electrons, color=colour_of_channel(name), lw=1.0, ls="--", label=f"{name} of the background")
    best = float(np.max(signal_e / total_e))
    axes.set(
        xlabel="signal, e⁻ of a photosite", ylabel="standard deviation, e⁻", xlim=(_FAINTEST_E, 1.3 * saturation_e)
    )
    axes.set_ylim(bottom=_LEAST_PART * float(total_e.min()))
    axes.grid(alpha=0.3, which="both")
    axes.legend(fontsize=8)
    axes.set_title(
        f"{camera.name}, ISO {iso:g}, {capture.time_s:.4g} s: a frame's signal over noise is {best:.0f} at most"
    )
