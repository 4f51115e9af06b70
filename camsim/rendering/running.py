"""Carrying out a plan: bands are rendered, checked, scaled, and stored or passed on."""

from __future__ import annotations

import functools
import operator
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.core.arrays import F64, I64, U8
from camsim.core.tiled import Channels, multiply
from camsim.core.typed import check
from camsim.errors import AccuracyError
from camsim.rendering.auto import Choice, choose
from camsim.rendering.direct.checks import Found
from camsim.rendering.engine import Plan, Progress, share
from camsim.rendering.work import Work

TAKEN_PHOTOSITES = 2_000_000  # 16 MB at a time are passed on
Report = Callable[[str, float], None]
Take = Callable[[F64], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """A noise-free image and the estimate of its error.

    image              : (rows, cols) float64, or (n, rows, cols) for n wavelengths; no rows if ``take`` received them
    error_estimate     : largest |image − reference| over the photosites checked, relative to the larger of a perfect
                         diffuser and the scene's brightest region in that channel
    standard_error     : for ``importance``: the largest standard error of a photosite, as if its samples were random
    checked_photosites : number of photosites that the independent check recomputed
    seconds            : wall time, set-up and check included
    method, tolerance  : the engine that ran and the tolerance requested
    wavelengths        : number of wavelength nodes
    work               : counts of what was computed
    planes             : (channels, rows, cols) every channel at every photosite, if requested
    planes_error       : the error estimate of ``planes``

    >>> import camsim
    >>> found = camsim.render(
    ...     camsim.Scene(background=0.5),
    ...     [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=4.0)],
    ...     camsim.Grid(rows=2, cols=3, pitch_um=4.0),
    ...     wavelength_nm=550.0,
    ... )
    >>> found.image.shape, found.error_estimate <= 1e-6
    ((2, 3), True)
    """

    image: F64
    error_estimate: float
    checked_photosites: int
    seconds: float
    method: str
    tolerance: float
    wavelengths: int
    work: Work
    standard_error: float | None = None
    planes: F64 | None = None
    planes_error: float | None = None

    def __repr__(self) -> str:
        size = " × ".join(map(str, self.image.shape))
        return f"Rendering({size} by {self.method}, error {self.error_estimate:.2g} of {self.tolerance:g})"


def carry_out(
    choice: Choice,
    channel: Channels,
    *,
    every_channel: bool = False,
    prune: bool = True,
    strict: bool = False,
    take: Take | None = None,
    progress: Report | None = None,
) -> Rendering:
    """Render every photosite in the channel assigned to it; arguments as in ``render_channels``."""
    check(take, Take | None, "take")
    check(progress, Report | None, "progress")
    begin = time.perf_counter()
    plan, checker, job = choice.plan, choice.checker, choice.plan.job
    plans = [plan] if prune or not len(job.left_out.edges) else [plan, _rest(choice)]
    report, scale = progress or to_nobody, job.signals.scale
    report("render", 0.0)
    rows, cols = checker.hardest(plan)
    sets = channel[rows, cols]
    planes, planes_found, images = None, None, 1
    if every_channel or not prune:
        images, channel = scale.size, channel[:]
        planes = np.empty((images, *channel.shape))
        values = np.empty((images, rows.size))
        each = np.arange(images, dtype=channel.dtype)[:, None]
        channels = np.broadcast_to(each[..., None], planes.shape)
        for k, bands in enumerate(_images(plans, channels, _part(report, 0.0, 0.9))):
            values[k] = _passed(bands, channels[k], scale, (rows, cols), _Into(planes[k]))
        right = checker.values(rows, cols, np.broadcast_to(each, values.shape))
        found_of = [Found.of(plan, item, its, rows, cols) for item, its in zip(values, right, strict=True)]
        planes_found = max(found_of, key=lambda found: found.error)
        image = np.take_along_axis(planes, channel[None].astype(np.intp), axis=0)[0]
        each_channel = sets, np.arange(rows.size)
        found = Found.of(plan, values[each_channel], right[each_channel], rows, cols)
    else:
        whole = _Into(np.empty((0 if take is not None else channel.shape[0], channel.shape[1])), or_itself=True)
        one = _passed(plan.bands(channel, _part(report, 0.0, 0.9)), channel, scale, (rows, cols), take or whole)
        image = whole.image
        found = Found.of(plan, one, checker.values(rows, cols, sets), rows, cols)
    if strict:
        for outcome in (found, planes_found):
            if outcome is not None:
                _refuse(outcome, choice)
    report("render", 1.0)
    checked = found.photosites + (0 if planes_found is None else images * planes_found.photosites)
    return Rendering(
        image=image,
        error_estimate=found.error,
        checked_photosites=found.photosites,
        seconds=time.perf_counter() - begin,
        method=choice.method,
        tolerance=job.tolerance,
        wavelengths=plan.wavelengths,
        work=_work(plans, images, checked),
        standard_error=found.standard_error,
        planes=planes if every_channel else None,
        planes_error=None if planes_found is None or not every_channel else planes_found.error,
    )


class _Into:
    """Writes bands of rows into an array from the top; ``or_itself``: a band of all rows may replace the array."""

    def __init__(self, image: F64, *, or_itself: bool = False) -> None:
        self.image, self._row, self._or_itself = image, 0, or_itself

    def rows(self, part: F64) -> F64:
        """Return the array into which this band of rows is to be written."""
        if self._or_itself and part.shape == self.image.shape and part.flags.owndata and part.flags.c_contiguous:
            self.image = part
            return part
        self._row += len(part)
        return self.image[self._row - len(part) : self._row]


def _passed(bands: Iterator[F64], channel: Channels, scale: F64, places: tuple[I64, I64], to: Take | _Into) -> F64:
    """Pass an image on in the unit of the response, and return its values at places, relative to full scale."""
    rows, cols = places
    values, first = np.empty(rows.size), 0
    for band in bands:
        here = (first <= rows) & (rows < first + len(band))
        values[here] = band[rows[here] - first, cols[here]]
        # An engine's bands grow with the frame; they are passed on in smaller pieces.
        step = max(1, TAKEN_PHOTOSITES // channel.shape[1])
        for part in np.split(band, range(step, len(band), step)) if step < len(band) else (band,):
            if isinstance(to, _Into):
                multiply(part, channel, first, scale, to.rows(part))
            else:
                multiply(part, channel, first, scale, part)
                to(part)
            first += len(part)
        del band, part  # frees them before the next band is computed
    return values


def _images(plans: Sequence[Plan], channels: U8, progress: Progress) -> Iterator[Iterator[F64]]:
    """Yield images, each the sum of several plans': in bands for one plan, in one piece for more."""
    if len(plans) == 1:
        yield from plans[0].images(channels, progress)
        return
    parts = (plan.images(channels, functools.partial(share, progress, k, len(plans))) for k, plan in enumerate(plans))
    for of_plans in zip(*parts, strict=True):
        image = np.zeros(channels.shape[1:])
        for bands in of_plans:
            whole = _Into(np.empty(image.shape))
            for band in bands:
                whole.rows(band)[:] = band
            image += whole.image
        yield iter((image,))


def _rest(choice: Choice) -> Plan:
    """Return a plan for the edges that were left out, with the settings of the other edges if there are any."""
    job = choice.plan.job
    return choice.plan.of(job.rest()) if len(job.edges) else choose(choice.method, job.rest(), choice.samples).plan


def _refuse(found: Found, choice: Choice) -> None:
    """Raise AccuracyError if an error is larger than the tolerance."""
    if found.error <= choice.plan.job.tolerance:
        return
    job = choice.plan.job
    grid, tolerance = job.grid, job.tolerance
    row, col = grid.origin[0] + found.row, grid.origin[1] + found.col
    way_out = (
        "report this as a bug of camsim, or allow more"
        if choice.method in ("boundary", "fourier")
        else "use method boundary, or allow more"
    )
    raise AccuracyError(
        f"photosite [{row}, {col}] is off by {found.error:.2g}, and the tolerance is {tolerance:g} "
        f"(method {choice.method}, the worst of {found.photosites} photosites recomputed); {way_out}",
        stage="render",
    )


def _work(plans: Sequence[Plan], images: int, checked: int) -> Work:
    """Add up the work of the job, of every plan and of the check."""
    job = plans[0].job
    found = Work(
        shapes=len(job.scene.shapes),
        outline_edges=job.left_out.outline_edges,
        edges_equal=job.left_out.equal if len(plans) == 1 else 0,
        edges_far=job.left_out.far if len(plans) == 1 else 0,
        wavelengths=job.signals.wavelength_nm.size,
        photosites_checked=checked if len(job.edges) else 0,
    )
    return functools.reduce(operator.add, (plan.work(images) for plan in plans), found)


def _part(report: Report, first: float, share: float) -> Progress:
    return lambda done: report("render", first + share * done)


def to_nobody(stage: str, fraction: float) -> None:
    """Ignore a progress report."""
