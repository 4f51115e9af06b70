"""Sensitivities from a chart: smooth curves if its patches determine them, else the nearest measured camera's.

24 patches determine a curve of 41 points only with prior knowledge. Here: it is not negative, it is 0 where silicon
behind an infrared filter has no response (below 390 and above 720 nm), and it is smooth: a Gaussian process whose
values 20 nm apart correlate by exp(-1/2), with the variance for each channel that maximises the likelihood of the
patches. The posterior standard deviation of the process is the stated error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.core.arrays import F64
from camsim.files.camera_curves import CameraCurves
from camsim.measure.colour.matrix import PatchColours
from camsim.spectra import named
from camsim.spectra.curve import Curve, spectrum_at

NODES_NM = np.arange(380.0, 781.0, 10.0)
SMOOTH_NM = 20.0
TRUSTED = 0.2
"""Largest stated error, root mean square relative to that of the curve, of curves reported as measured."""

_NOISE = np.geomspace(3e-4, 0.05, 16)
_HEIGHTS = np.geomspace(3e-3, 3.0, 25)
"""Trial standard deviations of the prior, on a scale where a flat curve gives white 1."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Smooth:
    """Curves estimated from a chart.

    values, sigma : (3, n) responses per energy at ``NODES_NM`` and their standard errors, the highest value is 1
    relative      : (3,) root mean squares of ``sigma`` over those of ``values``
    noise         : relative noise of the patches, from the fit
    """

    values: F64
    sigma: F64
    relative: F64
    noise: float

    @property
    def curves(self) -> dict[str, Curve]:
        """The curves by letter, responses per energy."""
        nodes_nm = NODES_NM.tolist()
        return {
            letter: Curve(nodes_nm, one, outside="zero")
            for letter, one in zip("RGB", self.values.tolist(), strict=True)
        }

    @property
    def trusted(self) -> bool:
        """Whether the chart determines every channel's curve."""
        return float(self.relative.max()) <= TRUSTED


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Nearest:
    """The measured camera whose response to the chart is nearest.

    curves : sensitivities of this camera, each channel scaled so that the chart's white is as measured
    misfit : root mean square difference of the patches, as a fraction of white
    """

    name: str
    curves: Mapping[str, Curve]
    per: str
    misfit: float


def smooth_curves(means: F64, error: F64, colours: PatchColours) -> Smooth:
    """Return the most likely smooth curves of channels with responses (n, 3) to patches, with standard errors."""
    seen = _of_nodes(colours)
    scale = seen.sum(axis=1).max()
    seen = seen / scale
    # 0 outside the camera's range; a step would ring.
    ends = 1.0 / (1.0 + np.exp((395.0 - NODES_NM) / 6.0)) / (1.0 + np.exp((NODES_NM - 715.0) / 8.0))
    steps = (NODES_NM[:, None] - NODES_NM) / SMOOTH_NM
    prior = np.exp(-0.5 * steps**2) * ends[:, None] * ends
    white = means.max(axis=0)
    displayed, scatter = means / white, error / white
    stated = seen @ prior @ seen.T
    best, noise, heights = -math.inf, _NOISE[0], [_HEIGHTS[0]] * 3
    for part in _NOISE:
        each = [_likeliest(displayed[:, k], _sigma(displayed[:, k], scatter[:, k], part), stated) for k in range(3)]
        if sum(likely for likely, _ in each) > best:
            best, noise, heights = sum(likely for likely, _ in each), part, [height for _, height in each]
    values, sigma = np.empty((3, NODES_NM.size)), np.empty((3, NODES_NM.size))
    for k, height in enumerate(heights):
        one, off = height**2 * prior, _sigma(displayed[:, k], scatter[:, k], noise)
        gain = np.linalg.solve(seen @ one @ seen.T + np.diag(off**2), seen @ one)
        sigma[k] = np.sqrt(np.maximum(np.diag(one - one @ seen.T @ gain), 0.0))
        # Non-negative least squares of the patches and of the prior's square root.
        root = np.linalg.cholesky(np.linalg.inv(one + 1e-6 * height**2 * np.eye(NODES_NM.size))).T
        rows = np.concatenate([seen / off[:, None], root])
        values[k] = scipy.optimize.nnls(
            rows, np.concatenate([displayed[:, k] / off, np.zeros(len(root))]), maxiter=10_000
        )[0]
    relative = np.sqrt((sigma**2).mean(axis=1) / np.maximum((values**2).mean(axis=1), 1e-30))
    values, sigma = values * white[:, None], sigma * white[:, None]
    highest = float(values.max())
    return Smooth(values=values / highest, sigma=sigma / highest, relative=relative, noise=float(noise))


def nearest_camera(means: F64, colours: PatchColours, cameras: Sequence[CameraCurves]) -> Nearest:
    """Return the camera, among those shipped and those given, whose response to the patches is nearest."""
    light = _fine(colours)
    shipped = [
        CameraCurves(name=name, curves=named.sensitivities(name), per="energy") for name in named.sensitivity_names()
    ]
    best: Nearest | None = None
    white = means.max(axis=0)
    for camera in (*shipped, *cameras):
        if not {"R", "G", "B"} <= set(camera.curves):
            continue
        chosen = [camera.curves[letter] for letter in "RGB"]
        per = light.nodes_nm if camera.per == "photon" else np.ones_like(light.nodes_nm)
        would = np.stack([light.power @ (curve.at(light.nodes_nm) * per) for curve in chosen], axis=1)
        if not would.max(axis=0).min() > 0.0:
            continue
        gains = (would * means).sum(axis=0) / (would * would).sum(axis=0)
        misfit = float(np.sqrt(np.mean(((would * gains - means) / white) ** 2)))
        if best is None or misfit < best.misfit:
            highest = max(gain * max(curve.values) for gain, curve in zip(gains, chosen, strict=True))
            scaled = {
                letter: Curve(curve.wavelength_nm, [value * gain / highest for value in curve.values], outside="zero")
                for letter, curve, gain in zip("RGB", chosen, gains.tolist(), strict=True)
            }
            best = Nearest(name=camera.name, curves=scaled, per=camera.per, misfit=misfit)
    assert best is not None, "two cameras are shipped"
    return best


def _likeliest(displayed: F64, sigma: F64, stated: F64) -> tuple[float, float]:
    """Return the maximal log-likelihood of a channel's patches, and the prior's standard deviation there."""
    best = -math.inf, float(_HEIGHTS[0])
    for height in _HEIGHTS:
        _, logarithm = np.linalg.slogdet(whole := height**2 * stated + np.diag(sigma**2))
        likely = float(-0.5 * (displayed @ np.linalg.solve(whole, displayed) + logarithm))
        best = max(best, (likely, float(height)))
    return best


def _sigma(displayed: F64, scatter: F64, part: float) -> F64:
    """Return standard deviations of a channel's patches: noise, and differences of real charts from their tables."""
    sigma: F64 = np.hypot(scatter, part * (0.7 * np.maximum(displayed, 0.0) + 0.1))
    return sigma


@dataclass(frozen=True, slots=True, eq=False)
class _Reflected:
    """Power of each patch (n, m) at nodes: the signal of a response of 1 per energy."""

    nodes_nm: F64
    power: F64


def _fine(colours: PatchColours) -> _Reflected:
    surfaces = [named.reflectance(name) for name in colours.names]
    nodes = Curve(NODES_NM.tolist(), np.ones(NODES_NM.size).tolist(), outside="hold")
    samples = colours.light.samples(surfaces, [nodes])
    power = samples.weight_nm * samples.irradiance_w_per_m2_nm
    reflected = np.array([spectrum_at(surface, samples.wavelength_nm) for surface in surfaces]) * power
    return _Reflected(samples.wavelength_nm, reflected)


def _of_nodes(colours: PatchColours) -> F64:
    """Return (n, nodes) the signal of each patch for hat functions at the nodes (linear interpolation)."""
    light = _fine(colours)
    hats = np.stack([np.interp(light.nodes_nm, NODES_NM, one, left=0.0, right=0.0) for one in np.eye(NODES_NM.size)])
    projected: F64 = light.power @ hats.T
    return projected
