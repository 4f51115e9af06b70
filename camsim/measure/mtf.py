"""From samples to figures: ``measure_edge`` for one region of one channel."""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Protocol

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.core.cores import one_blas_thread
from camsim.core.note import Note
from camsim.core.typed import check
from camsim.core.words import percent
from camsim.errors import UnsupportedError
from camsim.measure import spline
from camsim.measure.crossings import errors_of, falls_to, limit, rise_of
from camsim.measure.fit import EdgeFit, fit_edge
from camsim.measure.full_frame import NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL
from camsim.measure.geometry import EdgeLine, Roi
from camsim.measure.locate import locate
from camsim.measure.picture import LARGEST_SIGNAL, Channel, Plane, Samples
from camsim.measure.result import EdgeMtf, Figures, Theory
from camsim.measure.spline import TAIL

HIGHEST_CYCLES_PER_PIXEL, FREQUENCIES = 1.0, 201
_MOST_MTF = 1.3  # light has 1, a sharpened picture a little more
_CLIPPED = 0.002
_BELOW_BLACK = 0.1  # of the step
_PILED_UP = 0.02  # of a side's photosites
_NOISY, _NOISY_PART = 0.45, 3e-4  # codes, and of the step where there are none
_WIDE, _MOST_OFF = 0.1, 0.13
"""Rise over reach above which light spread far by aberrations matters; relative error of MTF50 per unit of that."""

_ONE_SIDED = 0.004  # of the step
_FALLS = 0.3  # of the step: a line spread beyond the region that is so far below 0
_LEANS, _LEANS_BY = 5.0, 0.003  # in its standard errors; by how much the MTF may then be too high
_WIDEST = 0.6  # of the region's reach: longer rises do not reach their levels


class TheoreticalOtf(Protocol):
    """A transfer function that a measurement can be compared with, whatever its origin."""

    def along_normal(self, frequency_cycles_per_pixel: F64, *, channel: str, line: EdgeLine) -> F64 | None:
        """Transfer function across the edge ``line`` in a channel, signed; None where nothing is known."""
        ...


def measure_edge(
    channel: Plane | Channel, roi: Roi, *, tail: bool = True, theory: TheoreticalOtf | None = None, what: str = ""
) -> EdgeMtf:
    """Measure one edge of one channel in a region of the image.

    channel : photosites of one colour, of ``Picture.select``
    roi    : (row, col, rows, cols) of the image, with one edge in it
    tail   : add the line spread beyond the region, by a fit of its 1/x²; False gives the plain ISO 12233 figure
    theory : a transfer function for comparison
    what   : name of the place in messages, before region and channel

    Raises UnsupportedError in one sentence when the region does not hold one measurable edge.

    >>> import camsim
    >>> frame = camsim.capture(
    ...     "slanted-edge", overrides=["region={rows: 96, cols: 96, origin: [950, 1330]}", "render.tolerance=1e-3"]
    ... )
    >>> channel = camsim.measure.picture_of_frame(frame).select("G1")[0]
    >>> edge = measure_edge(channel, Roi(0, 0, 96, 96), what="slanted-edge")
    >>> round(edge.figures.angle_deg), edge.mtf.shape == edge.frequency_cycles_per_pixel.shape
    (4, True)
    """
    check(channel, Plane | Channel, "channel")
    check(roi, Roi, "roi")
    check(tail, bool, "tail")
    check(theory, TheoreticalOtf | None, "theory")
    if isinstance(channel, Plane):
        channel = Channel((channel,))
    roi.check_inside(channel.reach)
    what = f"{what}roi {roi}, channel {channel.name}"
    samples = channel.inside(roi)
    _refuse_clipped(samples.stored, channel.planes[0], what)
    if not np.all(np.abs(samples.signal) <= LARGEST_SIGNAL):
        raise UnsupportedError(
            f"holds values that are no numbers (NaN or infinite) or above {LARGEST_SIGNAL:g}; choose another region",
            stage=what,
        )
    guess = locate(*channel.on_a_lattice(roi), roi=roi, what=what)
    widths = guess.line.half_widths(roi)
    pitch = channel.pitch_pixel
    if min(widths) < 4.0 * pitch:
        raise UnsupportedError(
            f"the region reaches only {min(widths):.1f} px beyond the edge; take at least {8.0 * pitch:.3g} px "
            "on either side, 32 for good figures",
            stage=what,
        )
    with one_blas_thread():
        fit = fit_edge(samples, channel, guess, reach=min(widths), what=what)
        _refuse_several(fit, what)
        _refuse_wide(fit, min(widths), what)
        _refuse_piled_up(samples, fit, roi, what)
        edge = _result(fit, channel, roi, tail=tail, theory=theory)
    _refuse_unlike_light(edge, what)
    return edge


def _result(fit: EdgeFit, channel: Channel, roi: Roi, *, tail: bool, theory: TheoreticalOtf | None) -> EdgeMtf:
    model, c = fit.model, fit.coefficients
    reach = fit.line.half_widths(roi)
    frequency = np.linspace(0.0, HIGHEST_CYCLES_PER_PIXEL, FREQUENCIES)
    curve = functools.partial(_curve, fit, reach=None if tail else reach)

    def alone(f: F64) -> F64:  # without its error
        transform, zero = _transform(model, c, f, None if tail else reach)
        return np.abs(transform) / zero

    mtf, error = curve(frequency)
    nyquist = channel.nyquist_cycles_per_pixel
    limits = [limit(frequency, mtf, error, level, alone) for level in (0.5, 0.3, 0.1)]
    of_nyquists, nyquist_errors = curve(np.array([nyquist, NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL]))
    ends = spline.transform_rows(np.zeros(1), model, None)[0].real  # the step including tails
    step, step_error = float(ends @ c), math.sqrt(max(float(ends @ fit.covariance @ ends), 0.0))
    rise, rise_error = rise_of(fit)
    low_row = np.zeros(c.size)
    low_row[0], low_row[model.columns + TAIL] = 1.0, -model.tail_end
    dark = fit.dark / fit.scale + float(low_row @ c)
    # contrast = step/(2·dark + step)
    slope = (2.0 * dark * ends - 2.0 * step * low_row) / (2.0 * dark + step) ** 2
    freedom = max(fit.photosites - c.size, 1)
    snr = step / fit.residual_rms if fit.residual_rms > 0.0 else math.inf
    notes = []
    # Light is not negative: with a dark side so far below black, the values are not light above black.
    known = 2.0 * dark + step > 0.0 and dark > -_BELOW_BLACK * step
    if not known:
        notes.append(Note("below-black", "the dark side lies below black, so contrast is not known", "contrast"))
    wide = fit.rise / min(reach)
    if tail and wide > _WIDE:
        text = (
            f"the edge rises over {percent(wide)} of what the region has beside it: behind coma or spherical "
            f"aberration MTF50 may be off by up to {percent(_MOST_OFF * wide)}, in a larger region by less"
        )
        notes.append(Note("wide-edge", text, "roi"))
    if (too_high := _leaning(fit, limits[0][0])) > _LEANS_BY:
        text = (
            "the line spread leans to one side, as behind coma; were it a line thinner than a photosite along the "
            f"edge, the MTF would be up to {percent(too_high)} too high where it falls to 50 %"
        )
        notes.append(Note("leaning-spread", text, "roi"))
    if fit.left_out:
        notes.append(Note("defects", f"{fit.left_out} photosites far from the fit were left out (defects)", "left_out"))
    if fit.gap_pixel > 0.25:
        text = f"sampling phases repeat: {fit.gap_pixel:.2f} px across the edge are never sampled"
        notes.append(Note("phases-repeat", text, "angle_deg"))
    whole, inside = (spline.transform_rows(np.zeros(1), model, r)[0].real @ c for r in (None, reach))
    fraction = float(1.0 - inside / whole)
    distance = np.arange(-math.floor(8.0 * reach[0]), math.floor(8.0 * reach[1]) + 1) / 8.0
    edge = EdgeMtf(
        figures=Figures(
            mtf50_cycles_per_pixel=limits[0][0],
            mtf30_cycles_per_pixel=limits[1][0],
            mtf10_cycles_per_pixel=limits[2][0],
            mtf_at_nyquist=float(of_nyquists[0]),
            mtf_at_nyquist_of_sensor=float(of_nyquists[1]),
            rise_10_90_pixel=rise,
            angle_deg=fit.line.moved(0.0, fit.turn_rad, 0.0).angle_deg,
            contrast=step / (2.0 * dark + step) if known else math.nan,
            snr=snr,
        ),
        standard_error=Figures(
            mtf50_cycles_per_pixel=limits[0][1],
            mtf30_cycles_per_pixel=limits[1][1],
            mtf10_cycles_per_pixel=limits[2][1],
            mtf_at_nyquist=float(nyquist_errors[0]),
            mtf_at_nyquist_of_sensor=float(nyquist_errors[1]),
            rise_10_90_pixel=rise_error,
            angle_deg=math.degrees(fit.turn_error_rad),
            contrast=math.sqrt(max(float(slope @ fit.covariance @ slope), 0.0)) if known else math.nan,
            snr=snr * math.hypot(step_error / step, 1.0 / math.sqrt(2.0 * freedom)),
        ),
        channel=channel.name,
        roi=roi,
        x_pixel=fit.line.x_pixel,
        y_pixel=fit.line.y_pixel,
        normal_deg=math.degrees(fit.line.normal_rad),
        curvature_per_pixel=fit.line.curvature_per_pixel,
        nyquist_cycles_per_pixel=nyquist,
        tail=tail,
        tail_fraction=fraction,
        frequency_cycles_per_pixel=frequency,
        mtf=mtf,
        mtf_error=error,
        distance_pixel=distance,
        esf=(spline.spread_rows(distance, model) @ c - float(low_row @ c)) / step,
        line_spread_per_pixel=spline.line_rows(distance, model) @ c / step,
        knot_spacing_pixel=model.spacing,
        photosites=fit.photosites,
        left_out=fit.left_out,
        notes=tuple(notes),
    )
    return edge if theory is None else with_theory(edge, fit.line, theory)


def with_theory(edge: EdgeMtf, line: EdgeLine, theory: TheoreticalOtf) -> EdgeMtf:
    """Add the theoretical transfer function to a measurement."""
    frequency, nyquist = edge.frequency_cycles_per_pixel, edge.nyquist_cycles_per_pixel
    asked = np.append(frequency, [nyquist, NYQUIST_OF_SENSOR_CYCLES_PER_PIXEL])
    otf = theory.along_normal(asked, channel=edge.channel, line=line)
    if otf is None:
        return edge
    mtf, of_nyquists = np.split(np.abs(otf), [frequency.size])
    half = falls_to(frequency, mtf, 0.5)
    if math.isfinite(half):
        fine = half + np.linspace(-1.0, 1.0, 81) * frequency[1]
        exact = theory.along_normal(fine, channel=edge.channel, line=line)
        assert exact is not None
        half = falls_to(fine, np.abs(exact), 0.5)
    at_its, at_sensors = of_nyquists.tolist()
    difference: F64 = edge.mtf - mtf
    return replace(
        edge,
        theory=Theory(
            mtf=mtf,
            difference=difference,
            mtf50_cycles_per_pixel=half,
            mtf_at_nyquist=at_its,
            mtf_at_nyquist_of_sensor=at_sensors,
            difference_to_nyquist=float(np.abs(difference[frequency <= nyquist + 1e-9]).max()),
        ),
    )


def _curve(fit: EdgeFit, frequency: F64, *, reach: tuple[float, float] | None) -> tuple[F64, F64]:
    """Return |F(f)|/F(0) and its standard error, (m,) each: from noise, or from the difference to other models."""
    rows = spline.transform_rows(np.append(frequency, 0.0), fit.model, reach)
    transform, zero = _split(rows, fit.coefficients)
    mtf = np.abs(transform) / zero
    unit = np.conj(transform) / np.where(mtf > 0.0, np.abs(transform), 1.0)
    gradient = ((unit[:, None] * rows[:-1]).real - mtf[:, None] * rows[-1].real) / zero
    by_noise = errors_of(gradient, fit.covariance)
    error = by_noise
    for other in fit.others:
        transform, zero = _transform(other.model, other.coefficients, frequency, reach)
        # The difference includes noise too, so the two are not added.
        error = np.maximum(error, other.error(np.abs(transform) / zero - mtf, by_noise))
    return mtf, error


def _transform(
    model: spline.Model, coefficients: F64, frequency: F64, reach: tuple[float, float] | None
) -> tuple[C128, float]:
    return _split(spline.transform_rows(np.append(frequency, 0.0), model, reach), coefficients)


def _split(rows: C128, coefficients: F64) -> tuple[C128, float]:
    """Return the transform, and at frequency 0, which is the last row."""
    whole: C128 = np.asarray(rows @ coefficients, np.complex128)
    return whole[:-1], float(whole[-1].real)


def _leaning(fit: EdgeFit, half: float) -> float:
    """Return by what fraction a thin line along the edge may have raised the MTF at frequency ``half``; 0 if by none.

    A line of width w, darker than the dark side by a steps, adds −s·w² to the variance of the line spread and
    s·√(1 + 4s)·w³ to its third cumulant κ, s = a(1 + a). So for any a the variance is too small by (κ/2)^(2/3) at most,
    and κ is known from the phase: φ(f) − 2φ(f/2) = (2πf)³κ/8. A lens with coma may have the same line spread.
    """
    if not math.isfinite(half):
        return 0.0
    f = np.array([0.5 * half, half])

    def phase(model: spline.Model, coefficients: F64) -> tuple[float, F64]:
        rows = spline.transform_rows(f, model, None)
        low, high = rows @ coefficients
        gradient: F64 = (rows[1] / high - 2.0 * rows[0] / low).imag
        return float(np.angle(high * np.conj(low) ** 2)), gradient

    found, gradient = phase(fit.model, fit.coefficients)
    error = float(errors_of(gradient[None], fit.covariance)[0])
    differences = [float(one.error(phase(one.model, one.coefficients)[0] - found, error)) for one in fit.others]
    if abs(found) <= _LEANS * max(error, *differences):
        return 0.0
    return math.expm1(0.5 * (4.0 * abs(found)) ** (2.0 / 3.0))


def _refuse_clipped(samples: np.ndarray, plane: Plane, what: str) -> None:
    if not samples.size:
        return
    if plane.white is not None:
        high = float(np.mean(samples >= plane.white))
        if high > _CLIPPED:
            raise UnsupportedError(
                f"{percent(high)} of the photosites are clipped highlights (at {plane.white:g} or above); expose less",
                stage=what,
            )
    if plane.lowest is not None:
        at_floor = samples <= plane.lowest
        low = float(np.mean(at_floor))
        # A constant dark side was not clipped: it has no noise.
        just_above = float(np.mean(samples == plane.lowest + 1))
        if low > _CLIPPED and just_above > 0.1 * low:
            raise UnsupportedError(
                f"{percent(low)} of the photosites are clipped shadows (at {plane.lowest:g}); expose "
                "more, or use a black level above 0",
                stage=what,
            )


def _refuse_piled_up(samples: Samples, fit: EdgeFit, roi: Roi, what: str) -> None:
    """Raise for highlights clipped below the largest storable value: 12 bits in 16, or clipped earlier.

    Light is no steadier where there is more of it. Of a bright side's farther half one number, its largest, comes more
    often than twice the next smaller one, and than any does on the dark side: there was more. Without noise, or with
    less than codes are apart, either side is one number.
    """
    codes = np.issubdtype(samples.stored.dtype, np.integer)
    if fit.noise[0] * fit.scale <= (_NOISY if codes else _NOISY_PART * fit.scale):
        return
    across, _ = fit.line.across_and_along(samples.x, samples.y)
    dark, bright = fit.line.half_widths(roi)
    _, of_dark = np.unique(samples.stored[across < -0.5 * dark], return_counts=True)
    values, of_bright = np.unique(samples.stored[across > 0.5 * bright], return_counts=True)
    if not (of_dark.size and of_bright.size):
        return
    steady = float(of_dark.max() / of_dark.sum())
    largest, next_one = (float(n / of_bright.sum()) for n in (of_bright[-1], of_bright[-2:-1].sum()))
    if largest > max(_PILED_UP, 2.0 * next_one, 1.5 * steady):
        raise UnsupportedError(
            f"{percent(largest)} of the bright side is one number, {values[-1]:g}, and none is larger, though the dark "
            "side is noisy: highlights are clipped there; expose less",
            stage=what,
        )


def _refuse_unlike_light(edge: EdgeMtf, what: str) -> None:
    """Raise UnsupportedError if the transform is not that of an edge, as light from beyond the region dominates."""
    most = edge.frequency_cycles_per_pixel[edge.mtf.argmax()]
    if not (edge.mtf[0] > 0.0 and edge.mtf.max() <= _MOST_MTF):
        stated = (
            f"comes to {edge.mtf.max():.2g} at {most:.2g} cycles per pixel, and light gives 1 at the most"
            if edge.mtf[0] > 0.0
            else f"has no step left with the {percent(abs(edge.tail_fraction))} that a fit of 1/x² adds beyond it"
        )
        raise UnsupportedError(
            f"its transfer function {stated}: the region holds structure or light that changes, not one edge "
            "between two "
            "even surfaces (or it was sharpened); make it smaller, or choose another",
            stage=what,
        )


def _refuse_wide(fit: EdgeFit, reach: float, what: str) -> None:
    """Raise UnsupportedError if the edge does not reach its two levels within the region."""
    rise = fit.rise
    if rise > _WIDEST * reach:
        raise UnsupportedError(
            f"the edge rises from 10 to 90 % over {rise:.0f} px or more, and the region reaches only {reach:.0f} px "
            f"beyond it; take {math.ceil(2.0 * rise)} px or more on either side",
            stage=what,
        )


def _refuse_several(fit: EdgeFit, what: str) -> None:
    """Raise UnsupportedError if the spread function is not that of a single edge."""
    model, c = fit.model, fit.coefficients
    d = np.linspace(-model.half_width, model.half_width, 8 * model.columns + 1)
    rough = 3.0 * math.sqrt(max(float(np.mean(np.diag(fit.covariance)[: model.columns])), 0.0))
    rows = spline.spread_rows(d, model)
    esf = rows @ c
    low, high = esf[0], esf[-1]
    step = high - low
    if step < 0.3:
        raise UnsupportedError(
            f"the two sides of the edge have nearly the same signal beyond {model.half_width:.0f} px, as "
            "beside a line or two edges; make the region narrower, so that it holds one edge",
            stage=what,
        )
    tail = model.columns + TAIL
    if math.pi * (float(c[tail]) + 3.0 * math.sqrt(max(float(fit.covariance[tail, tail]), 0.0))) < -_FALLS:
        raise UnsupportedError(
            "towards the region's ends the two sides come nearer to each other, as where a line or a second edge lies "
            "beside the edge; make the region narrower, so that it holds one edge",
            stage=what,
        )
    less, over = sorted(((low - esf.min()) / step, (esf.max() - high) / step))
    if over > 0.3 + rough:
        raise UnsupportedError(
            f"the signal overshoots its two sides by {100.0 * over:.0f} %, as beside a line or two edges; make "
            "the region narrower, so that it holds one edge",
            stage=what,
        )
    # Sharpening overshoots on both sides, optics on neither.
    farthest = rows[esf.argmin()] - rows[0] if low - esf.min() > esf.max() - high else rows[esf.argmax()] - rows[-1]
    known = float(errors_of(farthest[None] / step, fit.covariance)[0])
    if over > _ONE_SIDED + 4.0 * known and less < 0.25 * over:
        raise UnsupportedError(
            f"the signal overshoots one of its two sides by {percent(over)}, as where a thin line runs along the edge; "
            "choose an edge without one",
            stage=what,
        )
    systematic = fit.residual_rms > 0.05 and fit.residual_rms > 2.5 * max(fit.noise)
    if systematic:
        raise UnsupportedError(
            f"photosites miss the fit of one straight edge by {100.0 * fit.residual_rms:.0f} % of the step; "
            "the region holds a corner, two edges or structure: make it smaller",
            stage=what,
        )
