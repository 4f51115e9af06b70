"""Fit of a matrix to a chart's patches: red, green and blue to XYZ under the chart's light."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.measure.colour.reference import reference_xyz, white_of
from camsim.measure.demosaic.artefacts import delta_e_2000
from camsim.measure.demosaic.develop import lab_of
from camsim.sensor.colour_matrix import XYZ_D50, adaptation
from camsim.spectra import named
from camsim.spectra.light import Light

_DARK = 0.02
"""Level relative to a perfect diffuser below which, as in CIE Lab, absolute errors count instead of relative ones."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PatchColours:
    """Colorimetry of a chart's patches in a light.

    white_xyz : (3,) of a perfect diffuser, Y = 1
    xyz       : (n, 3) XYZ adapted to D50 (Bradford);  lab: (n, 3) CIE L*, a*, b* of these
    """

    light: Light
    names: tuple[str, ...]
    white_xyz: F64
    xyz: F64
    lab: F64

    @classmethod
    def of(cls, names: Sequence[str], light: Light) -> PatchColours:
        """Return the colours of named reflectances in a light."""
        xyz = reference_xyz(light, [named.reflectance(name) for name in names])
        return cls(light=light, names=tuple(names), white_xyz=white_of(light), xyz=xyz, lab=lab_of(xyz))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MatrixFit:
    """A matrix and its accuracy.

    to_xyz       : (3, 3) red, green and blue to XYZ in the chart's light; a perfect diffuser's Y is 1
    sigma        : (3, 3) standard errors of its numbers
    delta_e_2000 : (n,) of each patch, after the matrix
    left_out     : (n,) of each patch, with the matrix fitted to all others (leave-one-out)
    """

    to_xyz: F64
    sigma: F64
    delta_e_2000: F64
    left_out: F64


def quick_difference(means: F64 | None, colours: PatchColours) -> float:
    """Return the mean ΔE*ab after the best matrix: small if patches are in the right order, infinite without data."""
    if means is None or not np.isfinite(means).all() or not np.ptp(means) > 0.0:
        return float("inf")
    to_d50 = _linear(means, colours.xyz)
    return float(np.mean(np.linalg.norm(lab_of(means @ to_d50.T) - colours.lab, axis=1)))


def fit_matrix(means: F64, colours: PatchColours, used: npt.NDArray[np.bool_]) -> MatrixFit:
    """Fit a matrix to a chart's patches: least squares of CIE Lab differences with the weights of ΔE94.

    means : (n, 3) red, green and blue of each patch, above black;  used: (n,) mask of patches to fit

    Raises UnsupportedError if they do not determine a matrix.
    """
    if np.count_nonzero(used) < 8:
        message = f"{np.count_nonzero(used)} patches can be used, and a matrix needs 8; expose less"
        raise UnsupportedError(message, key="patches")
    matrix, sigma = _fitted(means[used], colours.xyz[used], colours.lab[used])
    spread = np.linalg.svd(matrix, compute_uv=False)
    if not spread[-1] > 1e-6 * spread[0]:
        raise UnsupportedError("its channels show the patches alike; there is no matrix", key="patches")
    left_out = np.full(len(means), np.nan)
    for k in np.flatnonzero(used):
        others = used & (np.arange(len(means)) != k)
        other, _ = _fitted(means[others], colours.xyz[others], colours.lab[others], matrix)
        left_out[k] = delta_e_2000(lab_of(means[k : k + 1] @ other.T), colours.lab[k : k + 1])[0]
    back = adaptation(XYZ_D50, colours.white_xyz)
    return MatrixFit(
        to_xyz=back @ matrix,
        sigma=np.sqrt(np.einsum("ij,jc->ic", back**2, sigma**2)),
        delta_e_2000=np.where(used, delta_e_2000(lab_of(means @ matrix.T), colours.lab), np.nan),
        left_out=left_out,
    )


def _linear(means: F64, xyz: F64) -> F64:
    """Return the (3, 3) matrix of least squares in XYZ, each patch weighted by the slope of Lab's cube root."""
    weight = (1.0 / np.maximum(xyz[:, 1], _DARK) ** (2.0 / 3.0))[:, None]
    return np.asarray(np.linalg.lstsq(means * weight, xyz * weight, rcond=None)[0].T, np.float64)


def _fitted(means: F64, xyz: F64, lab: F64, start: F64 | None = None) -> tuple[F64, F64]:
    """Return the matrix to XYZ under D50 and the standard errors of its numbers."""
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    hue = np.stack([lab[:, 1], lab[:, 2]], axis=1) / np.maximum(chroma, 1e-9)[:, None]
    hue[chroma < 1e-6] = (1.0, 0.0)
    of_chroma, of_hue = 1.0 + 0.045 * chroma, 1.0 + 0.015 * chroma

    def differences(flat: F64) -> F64:
        off = lab_of(means @ flat.reshape(3, 3).T) - lab
        along = off[:, 1] * hue[:, 0] + off[:, 2] * hue[:, 1]
        across = off[:, 2] * hue[:, 0] - off[:, 1] * hue[:, 1]
        return np.concatenate([off[:, 0], along / of_chroma, across / of_hue])

    first = _linear(means, xyz) if start is None else start
    solved = scipy.optimize.least_squares(differences, first.ravel(), x_scale=np.abs(first).max())
    freedom = max(1, differences(solved.x).size - 9)
    variance = 2.0 * solved.cost / freedom
    slopes = np.asarray(solved.jac, np.float64)
    covariance = variance * np.linalg.pinv(slopes.T @ slopes)
    return solved.x.reshape(3, 3), np.sqrt(np.diag(covariance)).reshape(3, 3)
