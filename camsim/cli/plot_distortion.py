"""Displacements of marks as a picture: arrows over the frame, and radial parts against the radius."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure.distortion import DistortionReport, GridReport


def draw(report: DistortionReport, file: str) -> bytes:
    """Return the plot as PNG, SVG or PDF, by the suffix of ``file``; its arrows show the reference channel."""
    figure = new_figure(11.0, 5.0)
    left, right = figure.subplots(1, 2)
    for channel in report.channels:
        marks, colour = channel.marks, colour_of_channel(channel.channel)
        x, y, dx, dy = (
            np.array([getattr(mark, name) for mark in marks]) for name in ("x_pixel", "y_pixel", "dx_pixel", "dy_pixel")
        )
        if channel.channel == report.reference:
            largest = float(np.hypot(dx, dy).max())
            left.quiver(x, y, dx, dy, angles="xy", color=colour)
            left.set_title(f"{channel.channel}: the longest arrow is {largest:.3g} px")
        radius = [mark.radius_pixel for mark in marks]
        error = [mark.error_pixel for mark in marks]
        radial = [mark.radial_pixel for mark in marks]
        order = np.argsort(radius)
        theory = np.array([mark.theory_radial_pixel for mark in marks])
        right.plot(np.array(radius)[order], theory[order], "--", lw=1.0, color=colour)
        right.errorbar(radius, radial, error, fmt="o", ms=3, lw=0.8, color=colour, label=channel.channel)
    left.plot([0], [0], "+", color="grey")
    left.invert_yaxis()
    left.set(xlabel="pixels from the optical axis", aspect="equal")
    right.axhline(0.0, color="black", lw=0.8)
    right.set(xlabel="pixels from the optical axis", ylabel="displacement away from it, pixels; dashed: theory")
    right.grid(alpha=0.3)
    right.legend(fontsize=8)
    figure.suptitle(f"{report.file}: {report.kind}")
    return bytes_of(figure, file)


def draw_grid(report: GridReport, file: str) -> bytes:
    """Return a plot of the magnified displacements of dots from where a projection without distortion puts them."""
    figure = new_figure(8.0, 6.0)
    axes = figure.subplots()
    for channel in report.channels:
        x, y, dx, dy = ([getattr(dot, f"{name}_pixel") for dot in channel.dots] for name in ("x", "y", "dx", "dy"))
        axes.quiver(x, y, dx, dy, angles="xy", width=0.002, label=channel.channel)
    axes.set_aspect("equal")
    axes.invert_yaxis()
    axes.set_title(f"{report.file}: displacement of dots, k1 {report.k1:+.4g}, k2 {report.k2:+.4g}")
    axes.set_xlabel("x, px")
    axes.set_ylabel("y, px")
    axes.legend()
    return bytes_of(figure, file)
