"""Scene, optics and grid in; a Rendering with its error out."""

from __future__ import annotations

import functools
import math
import operator
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.errors import AccuracyError, InvalidValueError
from camsim.optics import OpticalStage, OpticalSystem
from camsim.rendering.auto import Choice, check_method, choose
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.run import Found, Run, check, compare, hardest
from camsim.rendering.work import Work
from camsim.scene import Scene

LOOSEST = 1.0  # engines refuse less than this in words of their own
TAKEN_PHOTOSITES = 2_000_000
Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """A noise-free image and what is known of its error.

    image              : (rows, cols) float64, or (n, rows, cols) for n wavelengths
    error_estimate     : largest |image − reference| over the photosites checked, relative to the larger of a perfect
                         diffuser and the scene's brightest region in that channel
    standard_error     : of ``importance``: the largest standard error of a photosite's samples, taken for random
    checked_photosites : how many were computed again by the independent path
    seconds            : wall time, set-up and check included
    method, tolerance  : the engine that ran and what it was asked for
    wavelengths        : number of wavelength nodes
    work               : what was computed, counted
    planes             : (channels, rows, cols) every channel at every photosite, when that was asked for
    planes_error       : the same estimate for them
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


def render(
    scene: Scene,
    optics: Sequence[OpticalStage],
    grid: Grid,
    *,
    wavelength_nm: float | Sequence[float] | F64,
    tolerance: float = 1e-6,
    method: str = "auto",
    samples: int | None = None,
    strict: bool = False,
    prune: bool = True,
) -> Rendering:
    """Render a scene at one wavelength or at several, each on its own.

    wavelength_nm : nm, a number or a sequence of n
    tolerance     : largest absolute error of any photosite, 1.0 being a reflectance of 1 everywhere
    method        : "auto" (whichever engine is cheaper of those that can), "boundary", "fourier", or one of the
                    paper's: area, uniform-pixel, uniform, importance, strips (see sampled.py). Those have the error
                    they have; ``error_estimate`` says how much
    samples       : of ``importance``, 2025 by default
    strict        : raise AccuracyError where the error found is larger than ``tolerance``
    prune         : False computes even what need not be: see ``render_channels``

    The lens's transmission is left out: a reflectance of 1 everywhere gives exactly 1.

    >>> from camsim.optics import Airy, SquarePhotosite
    >>> white = Scene(background=1.0)
    >>> grid = Grid(rows=1, cols=2, pitch_um=4.0)
    >>> render(white, [Airy(f_number=8.0), SquarePhotosite(side_um=4.0)], grid, wavelength_nm=550.0).image
    array([[1., 1.]])
    """
    check_method(method)
    system = OpticalSystem.of(optics)
    channel = np.zeros((grid.rows, grid.cols), np.uint8)
    single = np.ndim(wavelength_nm) == 0
    parts = [
        render_channels(
            scene,
            system,
            grid,
            response=np.ones((1, 1)),
            wavelength_nm=np.array([w]),
            channel=channel,
            tolerance=tolerance,
            method=method,
            samples=samples,
            strict=strict,
            prune=prune,
        )
        for w in np.atleast_1d(np.asarray(wavelength_nm, float))
    ]
    if single:
        return parts[0]
    return Rendering(
        image=np.stack([part.image for part in parts]),
        error_estimate=max(part.error_estimate for part in parts),
        checked_photosites=sum(part.checked_photosites for part in parts),
        seconds=sum(part.seconds for part in parts),
        method=parts[0].method,
        tolerance=tolerance,
        wavelengths=len(parts),
        work=functools.reduce(operator.add, (part.work for part in parts)),
        standard_error=max((part.standard_error or 0.0 for part in parts), default=0.0) or None,
    )


def render_channels(
    scene: Scene,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    channel: U8,
    tolerance: float,
    method: str = "auto",
    samples: int | None = None,
    every_channel: bool = False,
    strict: bool = False,
    prune: bool = True,
    progress: Progress | None = None,
) -> Rendering:
    """Render every photosite in its own channel, all wavelengths fused.

    response      : (channels, n) signal of a perfect diffuser, quadrature weight included (electrons, or 1)
    wavelength_nm : (n,)
    channel       : (rows, cols) index of each photosite's channel
    every_channel : fill ``planes`` too; ``image`` is the same to the last bit either way
    strict        : raise AccuracyError where the error found is larger than ``tolerance``
    prune         : False computes what need not be, with the same settings: every channel everywhere, edges whose two
                    sides are alike, and those that are dropped because they add less than their share of the tolerance
    progress      : called with ("render", fraction done)
    returns       : image in the unit of ``response``
    """
    begin = time.perf_counter()
    job, choice = plan_render(
        scene,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=tolerance,
        method=method,
        samples=samples,
    )
    run, report = choice.run, progress or _silent
    runs = [run] if prune or not len(job.left_out.start) else [run, _rest(job, choice, samples)]
    report("render", 0.0)
    scale = job.signals.scale
    planes, planes_found = None, None
    if every_channel or not prune:
        planes = np.empty((scale.size, *channel.shape))
        everywhere = [np.full_like(channel, k) for k in range(scale.size)]
        for k, own in enumerate(everywhere):
            planes[k] = _image(runs, own, _part(report, 0.9 * k / scale.size, 0.9 / scale.size))
        planes_found = max((check(job, run, planes[k], own) for k, own in enumerate(everywhere)), key=lambda f: f.error)
        image = np.take_along_axis(planes, channel[None].astype(np.intp), axis=0)[0]
        planes *= scale[:, None, None]
    else:
        image = _image(runs, channel, _part(report, 0.0, 0.9))
    found = check(job, run, image, channel)
    if strict:
        for judged in (found, planes_found):
            _refuse(judged, choice, grid, tolerance)
    image *= scale[channel]
    report("render", 1.0)
    images = 1 if planes is None else scale.size
    checked = found.photosites + (0 if planes_found is None else images * planes_found.photosites)
    return Rendering(
        image=image,
        error_estimate=found.error,
        checked_photosites=found.photosites,
        seconds=time.perf_counter() - begin,
        method=choice.method,
        tolerance=tolerance,
        wavelengths=run.wavelengths,
        work=_work(scene, job, runs, images, checked),
        standard_error=found.standard_error,
        planes=planes if every_channel else None,
        planes_error=None if planes_found is None or not every_channel else planes_found.error,
    )


def plan_render(
    scene: Scene,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    tolerance: float,
    method: str = "auto",
    samples: int | None = None,
) -> tuple[Job, Choice]:
    """Decide everything and render nothing; arguments as in ``render_channels``."""
    check_method(method)
    if not 0.0 < tolerance <= LOOSEST:
        raise InvalidValueError(f"tolerance: {tolerance!r} is no error to keep below; give 1e-2 … 1e-11")
    for w in (wavelength_nm.min(), wavelength_nm.max()):
        if not (math.isfinite(w) and w > 0):
            raise InvalidValueError(f"wavelength_nm: {float(w)!r} is not a wavelength; give nm above 0")
    if not np.isfinite(response).all():
        raise InvalidValueError("response: not all of it is finite; give less light, or a shorter exposure")
    job = Job.of(scene, system, grid, response=response, wavelength_nm=wavelength_nm, tolerance=tolerance)
    return job, choose(method, job, samples)


def render_bands(
    scene: Scene,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    channel: U8,
    tolerance: float,
    take: Callable[[F64], None],
    method: str = "auto",
    strict: bool = False,
    progress: Progress | None = None,
) -> Rendering:
    """Render as ``render_channels`` does, to the last bit, and hand the image to ``take`` band by band, from the top.

    Nothing is kept: the image that is returned has no rows. Methods that cannot finish one row before another hand over
    everything as one band. With ``strict`` the error is known, and raised, only when all bands are out.
    """
    begin = time.perf_counter()
    job, choice = plan_render(
        scene,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=tolerance,
        method=method,
    )
    run, scale, report = choice.run, job.signals.scale, progress or _silent
    report("render", 0.0)
    rows, cols = hardest(job, run)
    values, first = np.empty(rows.size), 0
    for band in run.bands(channel, _part(report, 0.0, 0.9)):
        here = (first <= rows) & (rows < first + len(band))
        values[here] = band[rows[here] - first, cols[here]]
        # An engine's bands grow with the frame: what is done with them comes in smaller pieces.
        step = max(1, TAKEN_PHOTOSITES // grid.cols)
        for part in np.split(band, range(step, len(band), step)):
            part *= scale[channel[first : first + len(part)]]
            take(part)
            first += len(part)
        del band, part  # or they would stay until the next band is finished
    found = compare(job, run, values, rows, cols, channel[rows, cols])
    if strict:
        _refuse(found, choice, grid, tolerance)
    report("render", 1.0)
    return Rendering(
        image=np.empty((0, grid.cols)),
        error_estimate=found.error,
        checked_photosites=found.photosites,
        seconds=time.perf_counter() - begin,
        method=choice.method,
        tolerance=tolerance,
        wavelengths=run.wavelengths,
        work=_work(scene, job, [run], 1, found.photosites),
        standard_error=found.standard_error,
    )


def _rest(job: Job, choice: Choice, samples: int | None) -> Run:
    """Return what renders the edges that were left out, with the settings of the others if there are any."""
    rest = job.rest()
    return choice.run.of(rest) if job.edges else choose(choice.method, rest, samples).run


def _image(runs: Sequence[Run], channel: U8, progress: Callable[[float], None]) -> F64:
    """Add up what several runs give."""
    image = np.zeros(channel.shape)
    for number, run in enumerate(runs):
        row = 0
        for band in run.bands(channel, functools.partial(_share, progress, number, len(runs))):
            image[row : row + len(band)] += band
            row += len(band)
    return image


def _refuse(found: Found | None, choice: Choice, grid: Grid, tolerance: float) -> None:
    """Raise AccuracyError when an error is larger than asked."""
    if found is None or found.error <= tolerance:
        return
    row, col = grid.origin[0] + found.row, grid.origin[1] + found.col
    way_out = (
        "report this as a bug of camsim, or allow more"
        if choice.method in ("boundary", "fourier")
        else "use method boundary, or allow more"
    )
    raise AccuracyError(
        f"render: photosite [{row}, {col}] is off by {found.error:.2g}, and the tolerance is {tolerance:g} "
        f"(method {choice.method}, the worst of {found.photosites} photosites recomputed); {way_out}"
    )


def _work(scene: Scene, job: Job, runs: Sequence[Run], images: int, checked: int) -> Work:
    """Add up what was done: what the job found, what every run did, and the check."""
    found = Work(
        shapes=len(scene.shapes),
        outline_edges=job.left_out.outline_edges,
        edges_equal=job.left_out.equal if len(runs) == 1 else 0,
        edges_far=job.left_out.far if len(runs) == 1 else 0,
        wavelengths=job.signals.wavelength_nm.size,
        photosites_checked=checked if job.edges else 0,
    )
    return functools.reduce(operator.add, (run.work(images) for run in runs), found)


def _part(report: Progress, first: float, share: float) -> Callable[[float], None]:
    return lambda done: report("render", first + share * done)


def _share(progress: Callable[[float], None], number: int, count: int, done: float) -> None:
    progress((number + done) / count)


def _silent(stage: str, fraction: float) -> None:
    """Take a report of progress that nobody reads."""
