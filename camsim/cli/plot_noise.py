"""Photon transfer, SNR, linearity and spectrograms as a picture."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure.noise import NoiseReport


_MARKERS, _DASHES = "osD^v", (":", "--", "-.", (0, (5, 1, 1, 1, 1, 1)))
"""Channels overlap, so colour alone does not distinguish them."""


def draw(report: NoiseReport, file: str) -> bytes:
    """Return the plot as the bytes of a PNG, SVG or PDF, by the suffix of ``file``."""
    figure = new_figure(11.0, 8.0)
    (transfer, snr), (linear, spectra) = figure.subplots(2, 2)
    dashes = itertools.cycle(_DASHES)
    for channel, marker in zip(report.channels, itertools.cycle(_MARKERS)):
        colour, name = colour_of_channel(channel.channel), channel.channel
        signal, gain = channel.signal_dn, channel.transfer.gain_dn_per_e
        points = {"marker": marker, "ls": "", "ms": 5, "color": colour, "mfc": "none"}
        seen = (signal > 0.0) & (channel.variance_dn2 > 0.0)
        stated = f"{name}, {gain.value:.3g} DN/e⁻" if gain.measurable else name
        transfer.loglog(signal[seen], channel.variance_dn2[seen], **points, label=stated)
        if gain.measurable and seen.any():
            full = channel.saturation_e
            line = np.array([0.3 * signal[seen].min(), 1.5 * signal[seen].max()])
            transfer.loglog(line, gain.value * line, lw=1.0, color=colour)
            electrons = signal[seen] / gain.value
            snr.loglog(electrons, channel.snr[seen], **points, label=name)
            read = channel.transfer.read_noise_e
            if read.measurable:
                fine = np.geomspace(min(1.0, electrons.min()), 1.5 * electrons.max(), 100)
                snr.loglog(fine, fine / np.sqrt(fine + read.value**2), lw=1.0, color=colour)
            if full.measurable:
                end = "full well" if channel.transfer.full_well_e.measurable else "converter's end"
                label = f"{name}, {end} at {full.value:.4g} e⁻"
                transfer.axvline(gain.value * full.value, color=colour, ls=next(dashes), lw=1.0, label=label)
                snr.axvline(full.value, color=colour, ls=":", lw=0.8)
        slope = float(np.sum(channel.exposure / signal) / np.sum((channel.exposure / signal) ** 2))
        linear.plot(
            channel.exposure,
            100.0 * (signal / (slope * channel.exposure) - 1.0),
            lw=0.8,
            **points | {"ls": "-"},
            label=name,
        )
        for spectrogram, dash in ((channel.dark, "-"), (channel.flat, ":")):
            f, power = spectrogram.frequency_cycles_per_pixel[1:], spectrogram.rows[1:]
            word = "dark" if spectrogram is channel.dark else "flat at half of saturation"
            spectra.semilogy(f, np.maximum(power, 1e-6), dash, lw=1.0, color=colour, label=f"{name}, {word}")
    transfer.set(
        xlabel="signal above dark, DN", ylabel="variance above dark, DN²", title="photon transfer; line: photon noise"
    )
    snr.set(xlabel="signal, e⁻", ylabel="signal over noise", title="SNR; line: photon noise and read noise")
    linear.set(xlabel="light per photosite (relative)", ylabel="off a straight line, %", title="linearity")
    spectra.set(xlabel="cycles per pixel, along rows", ylabel="DN", title="spectrogram of fixed patterns")
    for axes in (transfer, snr, linear, spectra):
        axes.legend(fontsize=7)
    for axes in (transfer, snr, linear, spectra):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{report.source}: {report.frames} frames of {report.rows} × {report.cols}")
    return bytes_of(figure, file)
