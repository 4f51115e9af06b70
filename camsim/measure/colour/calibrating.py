"""A camera's colours from a photograph of a ColorChecker: matrix, white balance, sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from camsim.errors import UnsupportedError
from camsim.files.camera_curves import CameraCurves
from camsim.measure.colour.chart import Chart, Corner, read_chart, reflectance_names
from camsim.measure.colour.development import GREYS, development_of
from camsim.measure.colour.matrix import MatrixFit, PatchColours, fit_matrix
from camsim.measure.colour.sensitivities import NODES_NM, SMOOTH_NM, Nearest, Smooth, nearest_camera, smooth_curves
from camsim.measure.demosaic.artefacts import delta_e_2000
from camsim.measure.demosaic.develop import lab_of
from camsim.measure.given import check_given
from camsim.measure.picture import Picture
from camsim.sensor.measured_matrix import MeasuredMatrix
from camsim.spectra.light import Light

_DIGITS = 6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ColourCalibration:
    """A camera's colour calibration from a chart.

    file, light     : file and light of the photograph;  chart: name of the measured reflectances
    patches         : names;  clipped: names of those left out as clipped
    matrix          : as in sensor files;  sigma: (3, 3) standard errors, on its scale
    delta_e_before  : (n,) ΔE2000 of the file's matrix and white balance; None if it has none
    delta_e_after, delta_e_left_out : (n,) of the matrix; of leave-one-out fits
    smooth, nearest : sensitivities estimated from the chart, and the nearest measured camera
    """

    file: str
    light: str
    chart: str
    patches: tuple[str, ...]
    clipped: tuple[str, ...]
    matrix: MeasuredMatrix
    sigma: tuple[tuple[float, ...], ...]
    delta_e_before: tuple[float, ...] | None
    delta_e_after: tuple[float, ...]
    delta_e_left_out: tuple[float, ...]
    smooth: Smooth
    nearest: Nearest

    @property
    def white_balance(self) -> tuple[float, float, float]:
        """Red, green and blue of a perfect diffuser, relative to green."""
        red, green, blue = self.matrix.neutral.tolist()
        return red / green, 1.0, blue / green

    @property
    def measured(self) -> bool:
        """Whether curves estimated from the chart are used: they are reliable, and no measured camera fits as well."""
        return self.smooth.trusted and self.nearest.misfit > self.smooth.noise

    @property
    def sensitivities(self) -> str:
        """Text on the curves: their origin, the regulariser and its error, or why there are none."""
        errors = ", ".join(
            f"{letter} {100 * part:.0f} %" for letter, part in zip("RGB", self.smooth.relative.tolist(), strict=True)
        )
        smooth = (
            f"smooth curves (a Gaussian process of {SMOOTH_NM:g} nm, not negative, 0 below 390 and above 720 nm; noise "
            f"of the patches {100 * self.smooth.noise:.2g} %) have errors of {errors} of their root mean square"
        )
        nearest = (
            f"nearest measured camera: {self.nearest.name}, which would show the patches off by "
            f"{100 * self.nearest.misfit:.2g} % of white"
        )
        if self.measured:
            return f"{smooth}; {nearest}"
        why = "and a measured camera shows the chart the same" if self.smooth.trusted else "too much"
        return f"{smooth}, {why}; in their place the {nearest}"

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
        mean = {
            "before": None if self.delta_e_before is None else _mean(self.delta_e_before),
            "after": _mean(self.delta_e_after),
            "left_out": _mean(self.delta_e_left_out),
        }
        return {
            "file": self.file, "light": self.light, "chart": self.chart,
            "camera_to_xyz": [list(row) for row in self.matrix.camera_to_xyz],
            "camera_to_xyz_sigma": [list(row) for row in self.sigma],
            "white_xyz": list(self.matrix.white_xyz), "white_balance": list(self.white_balance),
            "delta_e_2000_mean": mean,
            "patches": [
                {
                    "name": name,
                    "delta_e_2000_before": None if self.delta_e_before is None else _finite(self.delta_e_before[k]),
                    "delta_e_2000_after": _finite(self.delta_e_after[k]),
                    "delta_e_2000_left_out": _finite(self.delta_e_left_out[k]),
                }
                for k, name in enumerate(self.patches)
            ],
            "clipped": list(self.clipped),
            "sensitivities": {
                "measured": self.measured, "words": self.sensitivities, "wavelength_nm": NODES_NM.tolist(),
                "values": dict(zip("RGB", self.smooth.values.tolist(), strict=True)),
                "sigma": dict(zip("RGB", self.smooth.sigma.tolist(), strict=True)),
                "nearest": self.nearest.name, "nearest_misfit": self.nearest.misfit,
            },
        }  # fmt: skip


def calibrate_colour(
    picture: Picture,
    light: Light,
    *,
    corners: Sequence[Corner] | None = None,
    chart: str = "ISO 17321-1",
    cameras: Sequence[CameraCurves] = (),
) -> ColourCalibration:
    """Calibrate a camera's colours from a ColorChecker in a raw picture.

    light   : uniform illumination of the chart; its level has no effect
    corners : (row, col) of the centres of the patches dark skin, bluish green, black and white; None: detected
    chart   : whose measured reflectances of the patches: "ISO 17321-1" or "BabelColor Average"
    cameras : further measured cameras, besides those shipped, for the nearest one

    Raises UnsupportedError if there is no chart, or too little of it.
    """
    check_given(picture=picture)
    colours = PatchColours.of(reflectance_names(chart), light)
    seen = read_chart(picture, colours, corners=corners, chart=chart)
    used = ~np.array(seen.clipped)
    try:
        fit = fit_matrix(seen.mean, colours, used)
    except UnsupportedError as why:
        raise UnsupportedError(why.message, stage=picture.name) from None
    one = replace(colours, names=tuple(np.array(colours.names)[used].tolist()))
    means, error = seen.mean[used], seen.error[used]
    return ColourCalibration(
        file=picture.name,
        light=light.name,
        chart=chart,
        patches=tuple(area.name for area in seen.areas),
        clipped=tuple(area.name for area, full in zip(seen.areas, seen.clipped, strict=True) if full),
        matrix=_matrix(fit, colours, light.name),
        sigma=_rows(fit.sigma / _scale(fit)),
        delta_e_before=_before(picture, seen, colours),
        delta_e_after=tuple(fit.delta_e_2000.tolist()),
        delta_e_left_out=tuple(fit.left_out.tolist()),
        smooth=smooth_curves(means, error, one),
        nearest=nearest_camera(means, one, cameras),
    )


def _matrix(fit: MatrixFit, colours: PatchColours, light: str) -> MeasuredMatrix:
    white = [round(value, _DIGITS) for value in colours.white_xyz.tolist()]
    return MeasuredMatrix(light=light, white_xyz=white, camera_to_xyz=_rows(fit.to_xyz / _scale(fit)))


def _scale(fit: MatrixFit) -> float:
    """Return the factor that makes the largest number 1."""
    return float(np.abs(fit.to_xyz).max())


def _rows(matrix: np.ndarray[Any, Any]) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(round(value, _DIGITS) for value in row) for row in matrix.tolist())


def _before(picture: Picture, seen: Chart, colours: PatchColours) -> tuple[float, ...] | None:
    """Return ΔE2000 of the patches with the file's matrix and white balance."""
    one = development_of(picture, seen.mean)
    if one is None:
        return None
    found = one.scaled(seen.mean, colours.xyz[GREYS, 1]).xyz(seen.mean)
    different = np.where(seen.clipped, np.nan, delta_e_2000(lab_of(found), colours.lab))
    return tuple(different.tolist())


def _mean(values: Sequence[float]) -> float:
    return float(np.nanmean(values))


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
