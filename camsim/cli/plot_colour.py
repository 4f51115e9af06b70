"""Plot of patch colours: positions in a*, b*, and errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camsim.cli.plot import bytes_of, new_figure
from camsim.core.arrays import F32, F64
from camsim.measure.demosaic.develop import developed
from camsim.sensor.colour_matrix import XYZ_D50

if TYPE_CHECKING:
    from camsim.measure.colour import ColourReport


def draw(report: ColourReport, file: str) -> bytes:
    """Return the plot as the bytes of a PNG, SVG or PDF, by the suffix of ``file``."""
    patches = report.patches
    measured = np.array([patch.lab for patch in patches])
    reference = np.array([patch.reference_lab for patch in patches])
    colours = _srgb(reference)
    figure = new_figure(11.0, max(5.0, 0.22 * len(patches) + 1.0))
    left, right = figure.subplots(1, 2)
    left.quiver(
        reference[:, 1],
        reference[:, 2],
        *(measured - reference)[:, 1:].T,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.004,
    )
    left.scatter(reference[:, 1], reference[:, 2], c=colours, s=60, edgecolor="black", lw=0.5)
    left.set(xlabel="a*", ylabel="b*", title="from the reference (dot) to what was measured", aspect="equal")
    left.grid(alpha=0.3)
    names = [patch.name for patch in patches][::-1]
    difference = [patch.delta_e_2000 for patch in patches][::-1]
    error = [patch.delta_e_error for patch in patches][::-1]
    right.barh(range(len(names)), difference, xerr=error, color=colours[::-1], edgecolor="black", lw=0.4)
    right.set_yticks(range(len(names)), names, fontsize=7)
    right.set(xlabel="ΔE2000", title=f"mean {report.delta_e_mean:.2f}, largest {report.delta_e_largest:.2f}")
    figure.suptitle(report.file)
    return bytes_of(figure, file)


def _srgb(lab: F64) -> F32:
    """Return (n, 3) sRGB of Lab under D50."""
    middle = (lab[:, 0] + 16.0) / 116.0
    root = np.stack([middle + lab[:, 1] / 500.0, middle, middle - lab[:, 2] / 200.0], axis=1)
    ratio = np.where(root > 6 / 29, root**3, 3.0 * (6 / 29) ** 2 * (root - 4 / 29))
    colours: F32 = developed(ratio[None].astype(np.float32), np.diag(XYZ_D50))[0]
    return colours
