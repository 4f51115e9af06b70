"""Photon transfer, SNR, linearity and spectrograms as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camsim.cli.plot import bytes_of, colour_of_channel, new_figure

if TYPE_CHECKING:
    from camsim.measure.noise import NoiseReport


def draw(report: NoiseReport, file: str) -> bytes:
    """Return a PNG, SVG or PDF, by the suffix of ``file``."""
    figure = new_figure(11.0, 8.0)
    (transfer, snr), (linear, spectra) = figure.subplots(2, 2)
    for channel in report.channels:
        colour, name = colour_of_channel(channel.channel), channel.channel
        signal, gain = channel.signal_dn, channel.transfer.gain_dn_per_e
        transfer.plot(signal, channel.variance_dn2, "o", ms=4, color=colour, label=name)
        if gain.measurable:
            transfer.plot(signal, gain.value * signal, lw=1.0, color=colour)
            electrons = signal / gain.value
            snr.loglog(electrons, channel.snr, "o", ms=4, color=colour, label=name)
            read = channel.transfer.read_noise_e.value
            fine = np.geomspace(max(electrons.min(), 1.0), electrons.max(), 100)
            snr.loglog(fine, fine / np.sqrt(fine + read**2), lw=1.0, color=colour)
        slope = float(np.sum(channel.exposure / signal) / np.sum((channel.exposure / signal) ** 2))
        linear.plot(channel.exposure, 100.0 * (signal / (slope * channel.exposure) - 1.0), "o-", ms=3, color=colour)
        for spectrogram, dash in ((channel.dark, "-"), (channel.flat, ":")):
            f, power = spectrogram.frequency_cycles_per_pixel[1:], spectrogram.rows[1:]
            word = "dark" if spectrogram is channel.dark else "flat at half of saturation"
            spectra.semilogy(f, np.maximum(power, 1e-6), dash, lw=1.0, color=colour, label=f"{name}, {word}")
    transfer.set(xlabel="signal above dark, DN", ylabel="variance above dark, DN²", title="photon transfer; line: gain")
    snr.set(xlabel="signal, e⁻", ylabel="signal over noise", title="SNR; line: photon noise and read noise")
    linear.set(xlabel="exposure", ylabel="off a straight line, %", title="linearity")
    spectra.set(xlabel="cycles per pixel, along rows", ylabel="DN", title="spectrogram of fixed patterns")
    for axes in (transfer, snr, spectra):
        axes.legend(fontsize=7)
    for axes in (transfer, snr, linear, spectra):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{report.source}: {report.frames} frames of {report.rows} × {report.cols}")
    return bytes_of(figure, file)
