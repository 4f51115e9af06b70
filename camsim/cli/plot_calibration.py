"""A calibration as a page of plots: photon transfer, residuals of the fits, spectra, histograms against the law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.stats

from camsim.cli.plot import bytes_of, new_figure
from camsim.sensor.stages.read_noise import tukey_sigma

if TYPE_CHECKING:
    from camsim.measure.calibrate import Calibration
    from camsim.measure.calibrate.likeness import SideBySide

_COLOURS = tuple(f"C{k}" for k in range(10))


def draw(found: Calibration, file: str) -> bytes:
    """Return the page as the bytes of a PNG, SVG or PDF, by the suffix of ``file``."""
    figure = new_figure(14.0, 9.0)
    (transfer, residual, over_iso), (row_axes, column_axes, histogram) = figure.subplots(2, 3)
    for number, setting in enumerate(setting for one in found.read_outs for setting in one.settings):
        colour, gain = _COLOURS[number % 10], setting.gain_dn_per_e
        label = f"ISO {setting.iso:g}, {1.0 / gain.value:.3g} e⁻/DN"
        for channel in setting.report.channels:
            seen = (channel.signal_dn > 0.0) & (channel.variance_dn2 > 0.0)
            signal, variance = channel.signal_dn[seen], channel.variance_dn2[seen]
            transfer.loglog(signal, variance, "o", ms=4, mfc="none", color=colour, label=label)
            residual.semilogx(
                signal, 100.0 * (variance / (gain.value * signal) - 1.0), "o-", ms=4, lw=0.5, color=colour
            )
            transfer.loglog(signal, gain.value * signal, lw=0.8, color=colour)
            label = "_"
        darks = setting.darks
        row_axes.loglog(
            darks.row_frequency, np.sqrt(darks.row_power), lw=0.6, color=colour, label=f"ISO {setting.iso:g}"
        )
        row_axes.axhline(math.sqrt(darks.temporal.dn2 / darks.shape[1]), color=colour, ls=":", lw=0.8)
        column_axes.loglog(
            darks.column_frequency, np.sqrt(darks.column_power), lw=0.6, color=colour, label=f"ISO {setting.iso:g}"
        )
        by_chance_dn2 = (darks.temporal.dn2 / darks.frames + max(darks.pattern.dn2, 0.0)) / darks.shape[0]
        column_axes.axhline(math.sqrt(by_chance_dn2), color=colour, ls=":", lw=0.8)
    gains = np.array([each.electrons_per_dn.value for each in found.settings])
    iso = np.array([each.iso for each in found.settings])
    noise_dn2 = np.array([each.darks.temporal.dn2 for each in found.settings]) - found.step_dn**2 / 12.0
    noise = np.sqrt(np.maximum(noise_dn2, 0.0))
    over_iso.loglog(iso, noise * gains, "o", mfc="none", label="darks")
    after = found.over_iso.after_dn2.value if found.over_iso.after_dn2.measurable else 0.0
    dual = found.over_iso.dual_from_iso
    high = np.zeros(iso.size, dtype=bool) if dual is None else iso >= dual
    fitted = found.over_iso.before_e2.value + max(after, 0.0) * gains**2
    if found.over_iso.dual_e2 is not None:
        fitted = np.where(high, found.over_iso.dual_e2.value + max(after, 0.0) * gains**2, fitted)
    over_iso.loglog(iso, np.sqrt(np.maximum(fitted, 1e-12)), "-", lw=1.0, label="before and after the gain")
    _draw_law(found, histogram)
    transfer.set(xlabel="signal above dark, DN", ylabel="variance above dark, DN²", title="photon transfer")
    residual.set(xlabel="signal above dark, DN", ylabel="off the line, %", title="residuals of the photon transfer")
    over_iso.set(xlabel="ISO", ylabel="read noise, e⁻", title="read noise over ISO")
    row_axes.set(xlabel="cycles per row", ylabel="DN", title="rows' offsets, frame by frame; dotted: by chance")
    column_axes.set(xlabel="cycles per column", ylabel="DN", title="columns' offsets that stay; dotted: by chance")
    for axes in (transfer, over_iso, row_axes, column_axes, histogram):
        axes.legend(fontsize=7)
    for axes in (transfer, residual, over_iso, row_axes, column_axes, histogram):
        axes.grid(alpha=0.3)
    figure.suptitle(f"{found.shots.name}: {len(found.shots.shots)} frames")
    return bytes_of(figure, file)


def _draw_law(found: Calibration, axes: object) -> None:
    """Draw differences of darks against the selected distribution, and a normal one."""
    setting, law = found.law_setting, found.law
    axes.set(title="no law of the read noise: too few darks")  # type: ignore[attr-defined]
    if setting is None or law is None:
        return
    codes = [np.asarray(each, np.float64) for each in setting.dark_codes]
    apart = np.concatenate([(a - b).ravel() for a, b in zip(codes[::2], codes[1::2], strict=False)]) / math.sqrt(2.0)
    step = found.step_dn
    reach = float(np.quantile(np.abs(apart), 1.0 - 1e-5))
    wide = max(step / math.sqrt(2.0), reach / 100.0)
    edges = (np.arange(-math.ceil(reach / wide) - 1, math.ceil(reach / wide) + 1) + 0.5) * wide
    count, _ = np.histogram(apart, edges)
    middle, density = 0.5 * (edges[1:] + edges[:-1]), count / apart.size / wide
    seen = count > 0
    axes.semilogy(middle[seen], density[seen], ".", ms=3, label=f"differences of darks / √2, ISO {setting.iso:g}")  # type: ignore[attr-defined]
    rng = np.random.default_rng(0)
    drawn = _draw_differences(found, rng)
    sizes, _ = np.histogram(drawn, edges)
    axes.semilogy(middle, np.maximum(sizes, 0.1) / drawn.size / wide, "-", lw=1.0, label=f"fitted: {law.shape.law}")  # type: ignore[attr-defined]
    sigma = float(np.std(apart))
    axes.semilogy(middle, scipy.stats.norm.pdf(middle, scale=sigma), "--", lw=0.8, label="normal")  # type: ignore[attr-defined]
    axes.set(  # type: ignore[attr-defined]
        xlabel="DN",
        ylabel="probability per DN",
        title="the law of the noise",
        ylim=(0.3 / apart.size / wide, 3.0 * float(density.max())),
    )


def _draw_differences(found: Calibration, rng: np.random.Generator) -> np.ndarray:
    """Draw a million random differences of two codes from the fitted distribution."""
    assert found.law is not None
    assert found.law_setting is not None
    shape, size = found.law.shape, (2, 1_000_000)
    if shape.law == "student":
        dof = 1.0 / shape.tails
        drawn = rng.standard_t(dof, size) * math.sqrt(1.0 - 2.0 / dof)
    elif shape.law == "tukey":
        p = np.clip(rng.random(size), 1e-16, 1.0 - 1e-16)
        drawn = scipy.stats.tukeylambda.ppf(p, shape.tails) / tukey_sigma(shape.tails)
    else:
        drawn = rng.standard_normal(size)
    spread = np.exp(shape.spread * rng.standard_normal(size[1]) - shape.spread**2)
    jumps = np.where(rng.random(size[1]) < shape.fraction, rng.exponential(1.0, size[1]) * shape.amplitude_dn, 0.0)
    darks = found.law_setting.darks
    after = found.over_iso.after_dn2.value if found.over_iso.after_dn2.measurable else 0.0
    other = math.sqrt(max(after, 0.0) + max(darks.rows.dn2, 0.0))
    read = shape.sigma_dn * spread * drawn + jumps * rng.integers(0, 2, size) + other * rng.standard_normal(size)
    codes = np.rint(read / found.step_dn + rng.random(size[1])) * found.step_dn
    apart: np.ndarray = (codes[0] - codes[1]) / math.sqrt(2.0)
    return apart


def draw_check(sides: Sequence[SideBySide], file: str) -> bytes:
    """Return a page of plots that compare a camera's frames with its profile's."""
    figure = new_figure(14.0, 4.2 * len(sides))
    rows = np.atleast_2d(figure.subplots(len(sides), 3))
    for side, (transfer, spectrum, quantiles) in zip(sides, rows, strict=True):
        order = np.argsort(side.mean_dn)
        transfer.semilogy(side.mean_dn[order], side.variance_dn2[order], "o", mfc="none", label="camera")
        transfer.semilogy(side.mean_dn[order], side.profile_variance_dn2[order], "x", label="profile")
        transfer.set(
            xlabel="mean, DN", ylabel="variance, DN²", title=f"ISO {side.iso:g} {side.read_out}: variance against mean"
        )
        for darks, label in ((side.darks, "camera"), (side.profile_darks, "profile")):
            spectrum.loglog(darks.row_frequency, np.sqrt(darks.row_power), lw=0.7, label=f"rows, {label}")
            spectrum.loglog(
                darks.column_frequency, np.sqrt(darks.column_power), lw=0.7, ls=":", label=f"columns, {label}"
            )
        spectrum.set(xlabel="cycles per row, per column", ylabel="DN", title="spectra of rows and columns in darks")
        share = scipy.stats.norm.cdf(np.linspace(-4.2, 4.2, 60))
        ours, theirs = (np.quantile(np.stack(codes), share) for codes in (side.dark_codes, side.profile_codes))
        quantiles.plot(ours, theirs, ".", label=f"KL {side.kl_nats:.2g} nats")
        quantiles.plot(ours, ours, lw=0.7, color="black")
        quantiles.set(xlabel="camera, DN", ylabel="profile, DN", title="quantiles of darks")
        for axes in (transfer, spectrum, quantiles):
            axes.legend(fontsize=7)
            axes.grid(alpha=0.3)
    return bytes_of(figure, file)
