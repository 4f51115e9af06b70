"""Scene, optics and grid in; a Rendering with its error out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64, U8
from camsim.errors import InvalidValueError, UnknownNameError, UnsupportedError
from camsim.optics import OpticalStage, OpticalSystem
from camsim.rendering import sampled
from camsim.rendering.engine import boundary_image
from camsim.rendering.footprint import Footprint
from camsim.rendering.grid import Grid
from camsim.rendering.hardest import hardest_photosites
from camsim.rendering.patterns import Pattern, pattern_of
from camsim.rendering.plan import Settings, check_tolerance, plan_boundary
from camsim.rendering.spectral import Signals, blur_of, fuse
from camsim.rendering.spotcheck import SHARE, Check, reference_values
from camsim.scene import Scene, arrange

METHODS = ("auto", "boundary", *sampled.METHODS)
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
    if method not in METHODS:
        raise UnknownNameError("method", method, METHODS)


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
    check_tolerance(tolerance, pattern_of(system.lens))
    for w in (wavelength_nm.min(), wavelength_nm.max()):
        if not (math.isfinite(w) and w > 0):
            raise InvalidValueError(f"wavelength_nm: {w!r} is not a wavelength; give nm above 0")
    job = _prepare(
        scene,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=tolerance,
        method="boundary" if method == "auto" else method,
        samples=samples,
    )
    report = progress or _silent

    def part(first: float, share: float) -> Callable[[float], None]:
        return lambda done: report("render", first + share * done)

    report("render", 0.0)
    scale = job.signals.scale
    planes, planes_error = None, None
    if every_channel:
        planes = np.empty((scale.size, *channel.shape))
        for k in range(scale.size):
            planes[k] = job.image(np.full_like(channel, k), part(0.9 * k / scale.size, 0.9 / scale.size))
        planes_error = max(job.check(plane, np.full_like(channel, k))[0] for k, plane in enumerate(planes))
        image = np.take_along_axis(planes, channel[None].astype(np.intp), axis=0)[0]
        planes *= scale[:, None, None]
    else:
        image = job.image(channel, part(0.0, 0.9))
    error, checked = job.check(image, channel)
    image *= scale[channel]
    report("render", 1.0)
    return Rendering(
        image=image,
        error_estimate=error,
        checked_photosites=checked,
        seconds=time.perf_counter() - begin,
        method=job.method,
        tolerance=tolerance,
        wavelengths=job.blur.size,
        planes=planes,
        planes_error=planes_error,
    )


def _silent(stage: str, fraction: float) -> None:
    """Take a report of progress that nobody reads."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Job:
    """Everything about one rendering, in pitches and in units of each channel's scale; the check has its own nodes."""

    start: F64
    end: F64
    pair: np.ndarray
    weights: F64
    base: F64
    blur: F64
    check_weights: F64
    check_blur: F64
    signals: Signals
    shares: F64
    fine_blur: F64
    system: OpticalSystem
    pattern: Pattern
    footprint: Footprint
    settings: Settings
    grid: Grid
    method: str
    samples: int | None

    def image(self, channel: U8, progress: Callable[[float], None]) -> F64:
        """Render the whole grid; ``progress`` is told the fraction done."""
        if not len(self.start):
            return self.base[channel]
        if self.method in sampled.METHODS:
            return self._sampled(channel)
        return boundary_image(
            start=self.start,
            end=self.end,
            pair=self.pair,
            weights=self.weights,
            base=self.base,
            pattern=self.pattern,
            blur=self.blur,
            system=self.system,
            pitch_um=self.grid.pitch_um,
            footprint=self.footprint,
            settings=self.settings,
            origin=self.grid.first_centre,
            channel=channel,
            progress=progress,
        )

    def _sampled(self, channel: U8) -> F64:
        if self.weights.shape[1:] != (1, 1):
            raise UnsupportedError(f"{self.method} renders one wavelength at a time: use boundary, or camsim.render")
        return sampled.sampled_image(
            self.method,
            samples=self.samples,
            start=self.start,
            end=self.end,
            contrast=self.weights[self.pair, 0, 0],
            background=float(self.base[0]),
            system=self.system,
            blur=float(self.blur[0]),
            side=self.footprint.side,
            spots=self.footprint.spots,
            origin=self.grid.first_centre,
            shape=(channel.shape[0], channel.shape[1]),
        )

    def check(self, image: F64, channel: U8) -> tuple[float, int]:
        """Return the worst error found and the number of photosites it was looked for at."""
        if not len(self.start):
            return 0.0, image.size
        check = Check.planned(self.pattern, self.fine_blur, self.shares, self.footprint, self.settings.tolerance)
        rows, cols = hardest_photosites(
            self.start, self.end, self.grid, self.settings, check, self.blur, self.weights.shape[0]
        )
        x0, y0 = self.grid.first_centre
        reference = reference_values(
            np.stack([x0 + cols, y0 + rows], axis=1),
            channel[rows, cols].astype(np.int64),
            start=self.start,
            end=self.end,
            pair=self.pair,
            weights=self.check_weights,
            base=self.base,
            pattern=self.pattern,
            blur=self.check_blur,
            check=check,
        )
        return float(np.abs(image[rows, cols] - reference).max()), rows.size


def _prepare(
    scene: Scene,
    system: OpticalSystem,
    grid: Grid,
    *,
    response: F64,
    wavelength_nm: F64,
    tolerance: float,
    method: str,
    samples: int | None,
) -> _Job:
    """Resolve the scene, choose nodes and settings."""
    pitch_um = grid.pitch_um
    pattern = pattern_of(system.lens)
    shortest_um = system.lens.blur_um(float(wavelength_nm[np.any(response != 0.0, axis=0)].min(initial=np.inf)))
    arrangement = arrange(scene, max_segment_um=shortest_um)
    start, end = arrangement.start_um / pitch_um, arrangement.end_um / pitch_um
    signals = Signals.of(arrangement, response, wavelength_nm)
    footprint = Footprint.of(system, pitch_um)
    sides, pair = np.unique(np.stack([arrangement.left, arrangement.right], axis=1), axis=0, return_inverse=True)
    fine = signals.blur(system, pitch_um)
    density = signals.density[sides[:, 0]] - signals.density[sides[:, 1]]
    shares = density.reshape(-1, fine.size) if len(sides) else np.zeros((1, fine.size))
    settings = plan_boundary(pattern, fine, shares, footprint, start, end, tolerance)
    phase = 2.0 * math.pi * settings.reach * float(1.0 / fine.min() - 1.0 / fine.max())
    nodes, by_spectrum = fuse(signals, phase=phase, tolerance=tolerance)
    check_nodes, check_by_spectrum = fuse(signals, phase=phase, tolerance=SHARE * tolerance)
    return _Job(
        start=start,
        end=end,
        pair=pair.ravel(),
        weights=by_spectrum[sides[:, 0]] - by_spectrum[sides[:, 1]],
        base=signals.density[0].sum(axis=1),
        blur=blur_of(system, nodes, pitch_um),
        check_weights=check_by_spectrum[sides[:, 0]] - check_by_spectrum[sides[:, 1]],
        check_blur=blur_of(system, check_nodes, pitch_um),
        signals=signals,
        shares=shares,
        fine_blur=fine,
        system=system,
        pattern=pattern,
        footprint=footprint,
        settings=settings,
        grid=grid,
        method=method,
        samples=samples,
    )
