"""The MTF of a star or a texture as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure.target import TargetReport


def draw(report: TargetReport, file: str) -> bytes:
    """Return a plot of the curves ± two standard errors, theory dashed; its format by the suffix of ``file``."""
    figure = new_figure(9.0, 5.0)
    axes = figure.subplots()
    for channel in report.channels:
        colour, f = colour_of_channel(channel.channel), channel.frequency_cycles_per_pixel
        axes.errorbar(
            f, channel.mtf, 2.0 * channel.mtf_error, fmt="o", ms=3, lw=0.8, color=colour, label=channel.channel
        )
        if channel.theory is not None:
            axes.plot(f, channel.theory, "--", lw=1.0, color=colour)
        axes.axvline(channel.nyquist_cycles_per_pixel, color=colour, lw=0.6, ls=":")
    axes.set(
        xlabel="cycles per pixel (of the sensor's pitch); dotted: Nyquist of the channel; bars: two standard errors",
        ylabel="MTF, mean over directions; dashed: theory",
        title=f"{report.file}: {report.method}",
    )
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    return bytes_of(figure, file)
