"""The MTF over the frame as a map: sagittal and tangential, of every channel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure
from camsim.errors import UnsupportedError

if TYPE_CHECKING:
    from camsim.measure import MtfReport
    from camsim.measure.full_frame import Unit

_DIRECTIONS = ("sagittal", "tangential")
_LEAST_FOR_AREA = 4


def draw_map(report: MtfReport, file: str, unit: Unit) -> bytes:
    """Return a plot of MTF50 over the frame and against the image height; its format by the suffix of ``file``.

    Raises UnsupportedError if no edge is along the radius or across it.
    """
    from camsim.measure.full_frame import UNITS

    frame = report.full_frame
    channels = list(dict.fromkeys(edge.channel for edge in report.edges))
    found: dict[tuple[str, str], list[tuple[float, ...]]] = {(c, d): [] for c in channels for d in _DIRECTIONS}
    for edge in report.edges:
        place, half = report.place(edge), frame.per_unit(unit) * edge.figures.mtf50_cycles_per_pixel
        if place.direction in _DIRECTIONS and np.isfinite(half):
            theory = edge.theory.mtf50_cycles_per_pixel if edge.theory is not None else np.nan
            points = (place.x_pixel, place.y_pixel, place.radius_pixel, half, frame.per_unit(unit) * theory)
            found[edge.channel, place.direction].append((*points, edge.normal_deg))
    displayed = {key: np.array(points) for key, points in found.items() if points}
    if not displayed:
        raise UnsupportedError(
            "no edge lies along the radius or across it, and a map shows those; camsim's chart lens-grid has many",
            stage=report.file,
        )
    every = np.concatenate([points[:, 3] for points in displayed.values()])
    limits = {"vmin": float(every.min()), "vmax": float(every.max())}
    half_size = _half_size(report)
    figure = new_figure(10.0, 3.4 * len(channels) + 2.4)
    rows = figure.subplots(len(channels) + 1, 2, squeeze=False, height_ratios=[3.4] * len(channels) + [2.4])
    mark: Any = None
    for channel, axes_of_channel in zip(channels, rows[:-1], strict=True):
        for axes, direction in zip(axes_of_channel, _DIRECTIONS, strict=True):
            drawn = displayed.get((channel, direction))
            if drawn is not None:
                mark = _map(axes, drawn, limits)
            axes.set(xlim=(-half_size[0], half_size[0]), ylim=(half_size[1], -half_size[1]), aspect="equal")
            axes.plot([0], [0], "+", color="grey")
            axes.set_title(f"{channel}, {direction}: {0 if drawn is None else len(drawn)} edges", fontsize=9)
    figure.colorbar(mark, ax=rows[:-1].ravel().tolist(), label=f"MTF50, {UNITS[unit]}", shrink=0.8)
    _course(rows[-1], displayed, f"MTF50, {unit}")
    figure.suptitle(f"{report.file}: MTF50 over the frame, pixels from the optical axis")
    return bytes_of(figure, file)


def _half_size(report: MtfReport) -> tuple[float, float]:
    """Return the extent of a map from the axis along x and y; a window may be on either side of it, or around it."""
    x, y = report.full_frame.axis_x_pixel, report.full_frame.axis_y_pixel
    regions = [edge.roi for edge in report.edges]
    right, bottom = (max(ends) for ends in zip(*((r.col + r.cols, r.row + r.rows) for r in regions), strict=True))
    return max(abs(x), right - x), max(abs(y), bottom - y)


def _map(axes: Any, points: Any, limits: dict[str, float]) -> Any:
    """Draw places as pieces of their edges, and an interpolated area if there are enough."""
    x, y, half, normal = points[:, 0], points[:, 1], points[:, 3], np.radians(points[:, 5])
    if len(points) >= _LEAST_FOR_AREA and np.linalg.matrix_rank(np.stack([x - x[0], y - y[0]]), tol=1e-6) == 2:
        axes.tripcolor(x, y, half, shading="gouraud", alpha=0.5, **limits)
    size = 0.03 * max(np.ptp(x), np.ptp(y), 100.0)
    along = np.stack([-np.sin(normal), np.cos(normal)]) * size
    axes.plot([x - along[0], x + along[0]], [y - along[1], y + along[1]], color="black", lw=0.8)
    return axes.scatter(x, y, c=half, s=28, edgecolor="black", lw=0.4, **limits)


def _course(row: Any, displayed: dict[tuple[str, str], Any], label: str) -> None:
    for axes, direction in zip(row, _DIRECTIONS, strict=True):
        for (channel, one), points in displayed.items():
            if one == direction:
                order = np.argsort(points[:, 2])
                colour = colour_of_channel(channel)
                axes.plot(points[order, 2], points[order, 3], "o", ms=4, color=colour, label=channel)
                axes.plot(points[order, 2], points[order, 4], "--", marker="_", lw=1.0, color=colour)
        axes.set(xlabel="pixels from the optical axis; dashed: theory", ylabel=label, title=direction)
        axes.grid(alpha=0.3)
        if any(one == direction for _, one in displayed):
            axes.legend(fontsize=7)
