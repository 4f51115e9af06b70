"""Where marks should be seen: the lens's distortion, and the middle of the light of its pattern there.

With x̄ the middle of a pattern's light the transfer begins 1 − 2πi f·x̄, so that x̄ is told by the transfer near 0:
lateral colour and coma are in it. A channel sees the mean over its wavelengths. The image of a dot is taken as moved
by x̄; a fitted rim follows the peak of a lopsided pattern a little more than its middle.
"""

from __future__ import annotations

import numpy as np

from camsim.arrays import F64
from camsim.exposing import Capture
from camsim.measure.distortion.marks import Marks
from camsim.measure.lens_places import fallen_um, system_at
from camsim.optics.protocols import Varies
from camsim.spectra.curve import spectrum_at

_WAVELENGTHS = 9
_NEAR_ZERO = 1e-3
"""Of the cut-off: where a transfer's phase is asked."""


def expected_um(capture: Capture, marks: Marks) -> dict[str, F64]:
    """Return by how much (n, 2) each channel should see marks farther to the right and farther down."""
    camera = capture.camera
    fallen = fallen_um(camera, marks.places_um)
    samples = camera.samples(capture.light, marks.surfaces)
    dark, light = (spectrum_at(surface, samples.wavelength_nm) for surface in marks.surfaces)
    weight = camera.electrons_per_reflectance(samples, 1.0) * np.abs(light - dark)
    seen = samples.wavelength_nm[weight.max(axis=0) > 0.0]
    if not seen.size:
        return dict.fromkeys(camera.cfa.channels, fallen - marks.places_um)
    nm = np.unique(np.linspace(float(seen.min()), float(seen.max()), _WAVELENGTHS))
    places = fallen if isinstance(camera.lens, Varies) else np.zeros((1, 2))
    centres = np.array([[_centre_um(capture, place, float(each)) for each in nm] for place in places.tolist()])
    share = np.array([np.interp(samples.wavelength_nm, nm, row) for row in np.eye(nm.size)])  # (wavelengths, samples)
    expected = {}
    for name, own in zip(camera.cfa.channels, weight, strict=True):
        part = np.einsum("kn,n->k", share, own) / max(float(own.sum()), 1e-300)
        expected[name] = fallen - marks.places_um + np.einsum("k,mkx->mx", part, centres)
    return expected


def _centre_um(capture: Capture, place_um: list[float], wavelength_nm: float) -> list[float]:
    """Return the middle of the light of the pattern at a place, from there."""
    system = system_at(capture.camera, *place_um)
    f = _NEAR_ZERO * system.cutoff_per_um(wavelength_nm)
    otf = system.point_otf(np.array([f, 0.0]), np.array([0.0, f]), wavelength_nm)
    middle: list[float] = (-np.imag(otf) / (2.0 * np.pi * f)).tolist()
    return middle
