"""Scene, optics and grid in; a Rendering with its error out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.errors import InvalidValueError, UnknownNameError
from camsim.optics import OpticalStage, OpticalSystem
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.methods import METHODS, BandedRun, prepare
from camsim.scene import Scene

NAMES = ("auto", *METHODS)
Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rendering:
    """A noise-free image and what is known of its error.

    image              : (rows, cols) float64, or (n, rows, cols) for n wavelengths
    error_estimate     : largest |image − reference| over the photosites checked, relative to the larger of a perfect
                         diffuser and the scene's brightest region in that channel
    checked_photosites : how many were computed again by the independent path
    seconds            : wall time, set-up and check included
    method, tolerance  : the engine that ran and what it was asked for
    wavelengths        : number of wavelength nodes
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
) -> Rendering:
    """Render a scene at one wavelength or at several, each on its own.

    wavelength_nm : nm, a number or a sequence of n
    tolerance     : largest absolute error of any photosite, 1.0 being a reflectance of 1 everywhere
    method        : "auto" (today always "boundary"), or one of the paper's: area, uniform-pixel, uniform, importance,
                    strips (see sampled.py). Those have the error they have; ``error_estimate`` says how much
    samples       : of ``importance``, 2025 by default

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
    )


def check_method(method: str) -> None:
    """Refuse the name of a method that does not exist."""
    if method not in NAMES:
        raise UnknownNameError("method", method, NAMES)


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
    progress: Progress | None = None,
) -> Rendering:
    """Render every photosite in its own channel, all wavelengths fused.

    response      : (channels, n) signal of a perfect diffuser, quadrature weight included (electrons, or 1)
    wavelength_nm : (n,)
    channel       : (rows, cols) index of each photosite's channel
    every_channel : fill ``planes`` too; ``image`` is the same to the last bit either way
    progress      : called with ("render", fraction done)
    returns       : image in the unit of ``response``
    """
    begin = time.perf_counter()
    _refuse_no_wavelengths(wavelength_nm)
    job = Job.of(scene, system, grid, response=response, wavelength_nm=wavelength_nm, tolerance=tolerance)
    chosen = _chosen(method)
    run = prepare(chosen, job, samples)
    report = progress or _silent

    def part(first: float, share: float) -> Callable[[float], None]:
        return lambda done: report("render", first + share * done)

    report("render", 0.0)
    scale = job.signals.scale
    planes, planes_error = None, None
    if every_channel:
        planes = np.empty((scale.size, *channel.shape))
        for k in range(scale.size):
            planes[k] = run.image(np.full_like(channel, k), part(0.9 * k / scale.size, 0.9 / scale.size))
        planes_error = max(run.check(plane, np.full_like(channel, k))[0] for k, plane in enumerate(planes))
        image = np.take_along_axis(planes, channel[None].astype(np.intp), axis=0)[0]
        planes *= scale[:, None, None]
    else:
        image = run.image(channel, part(0.0, 0.9))
    error, checked = run.check(image, channel)
    image *= scale[channel]
    report("render", 1.0)
    return Rendering(
        image=image,
        error_estimate=error,
        checked_photosites=checked,
        seconds=time.perf_counter() - begin,
        method=chosen,
        tolerance=tolerance,
        wavelengths=run.wavelengths,
        planes=planes,
        planes_error=planes_error,
    )


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
    progress: Progress | None = None,
) -> Rendering:
    """Render as ``render_channels`` does, to the last bit, and hand the image to ``take`` band by band, from the top.

    Nothing is kept: the image that is returned has no rows. Methods that cannot finish one row before another hand over
    everything as one band.
    """
    begin = time.perf_counter()
    _refuse_no_wavelengths(wavelength_nm)
    job = Job.of(scene, system, grid, response=response, wavelength_nm=wavelength_nm, tolerance=tolerance)
    chosen = _chosen("auto")
    run = prepare(chosen, job, None)
    scale, report = job.signals.scale, progress or _silent
    report("render", 0.0)
    if isinstance(run, BandedRun):
        rows, cols = run.hardest()
        values, first = np.empty(rows.size), 0
        for band in run.bands(channel):
            here = (first <= rows) & (rows < first + len(band))
            values[here] = band[rows[here] - first, cols[here]]
            band *= scale[channel[first : first + len(band)]]
            take(band)
            first += len(band)
            report("render", 0.9 * first / grid.rows)
        error, checked = run.compare(values, rows, cols, channel[rows, cols])
    else:
        image = run.image(channel, lambda done: report("render", 0.9 * done))
        error, checked = run.check(image, channel)
        image *= scale[channel]
        take(image)
    report("render", 1.0)
    return Rendering(
        image=np.empty((0, grid.cols)),
        error_estimate=error,
        checked_photosites=checked,
        seconds=time.perf_counter() - begin,
        method=chosen,
        tolerance=tolerance,
        wavelengths=run.wavelengths,
    )


def _refuse_no_wavelengths(wavelength_nm: F64) -> None:
    for w in (wavelength_nm.min(), wavelength_nm.max()):
        if not (math.isfinite(w) and w > 0):
            raise InvalidValueError(f"wavelength_nm: {w!r} is not a wavelength; give nm above 0")


def _chosen(method: str) -> str:
    """Return the method that renders: the one named, or the one that "auto" means."""
    return "boundary" if method == "auto" else method


def _silent(stage: str, fraction: float) -> None:
    """Take a report of progress that nobody reads."""
