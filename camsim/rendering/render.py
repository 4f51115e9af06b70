"""Entry points: render a scene through optics onto a grid, with an estimate of the error."""

from __future__ import annotations

import dataclasses
import functools
import math
import operator
import time
from collections.abc import Sequence
from typing import Annotated, Literal, TypeAlias

import numpy as np
from annotated_types import MinLen

from camsim.core.arrays import F64, U8
from camsim.core.calls import in_words
from camsim.core.memory import too_large
from camsim.core.typed import Number, Positive, Several, Whole, check, check_truths
from camsim.errors import InvalidValueError
from camsim.optics import OpticalStage, OpticalSystem
from camsim.optics.custom import check_transfer
from camsim.optics.declared import check_declared, check_lengths
from camsim.optics.protocols import Varies
from camsim.rendering.auto import IMAGE_BYTES, Choice, check_method, choose
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.engine import FINEST
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.share import edges_share
from camsim.rendering.grid import Grid
from camsim.rendering.job import Job
from camsim.rendering.outlines import arranged
from camsim.rendering.paper import rules
from camsim.rendering.running import Rendering, Report, Take, carry_out
from camsim.rendering.scales import check_scales
from camsim.rendering.spectral import carrying
from camsim.scene import Scene
from camsim.scene.arrange import Arrangement
from camsim.spectra.curve import check_wavelengths

AnyMethod: TypeAlias = Literal[
    "auto", "boundary", "fourier", "area", "uniform-pixel", "uniform", "importance", "strips"
]
LOOSEST = 1.0  # engines have tighter limits, with separate messages
_WAVELENGTHS = Positive | Annotated[tuple[Positive, ...], MinLen(1)]


@in_words
def render(
    scene: Scene,
    optics: Sequence[OpticalStage],
    grid: Grid,
    *,
    wavelength_nm: Number | Several[Number],
    tolerance: Number = 1e-6,
    method: AnyMethod = "auto",
    samples: Whole | None = None,
    strict: bool = False,
    prune: bool = True,
) -> Rendering:
    """Render a scene at one wavelength, or separately at each of several.

    wavelength_nm : nm, a number or a sequence of n
    tolerance     : largest absolute error of any photosite, 1.0 being a reflectance of 1 everywhere
    method        : "auto" (the cheaper of the engines that apply), "boundary", "fourier", or a sampling method: area,
                    uniform-pixel, uniform, importance, strips (see ``paper.rules``). The latter ignore ``tolerance``;
                    ``error_estimate`` gives their error
    samples       : number of samples of ``importance``, 2025 by default
    strict        : raise AccuracyError if the error found is larger than ``tolerance``
    prune         : False also computes the parts that are not needed: see ``render_channels``

    The lens's transmission is not applied: a reflectance of 1 everywhere gives exactly 1.

    >>> from camsim.optics import Airy, SquarePhotosite
    >>> white = Scene(background=1.0)
    >>> grid = Grid(rows=1, cols=2, pitch_um=4.0)
    >>> render(white, [Airy(f_number=8.0), SquarePhotosite(side_um=4.0)], grid, wavelength_nm=550.0).image
    array([[1., 1.]])
    """
    check_method(method)
    check(scene, Scene, "scene")
    check(grid, Grid, "grid")
    check_truths(strict=strict, prune=prune)
    counted: int | None = check(samples, int | None, "samples")
    allowed: float = check(tolerance, float, "tolerance")
    each_nm = np.atleast_1d(np.asarray(check(wavelength_nm, _WAVELENGTHS, "wavelength_nm"), np.float64))
    check_wavelengths(each_nm.tolist(), "wavelength_nm")
    system = OpticalSystem.of(optics)
    _check(system, grid, each_nm, allowed, method)
    _refuse_too_many(grid, len(each_nm))
    system, grid = _level(system, grid)
    channel = np.zeros((grid.rows, grid.cols), np.uint8)
    framed, budget = scene.framed(scene.background), ErrorBudget(edges_share(scene) * allowed)
    arrangement = arranged(framed, system, grid, each_nm, budget, textured=framed is not scene)
    parts = []
    for nm in each_nm:
        begin = time.perf_counter()
        choice = plan_render(
            scene,
            system,
            grid,
            response=np.ones((1, 1)),
            wavelength_nm=np.array([nm]),
            tolerance=allowed,
            method=method,
            samples=counted,
            arrangement=arrangement,
        )
        part = carry_out(choice, channel, prune=prune, strict=strict)
        parts.append(dataclasses.replace(part, seconds=time.perf_counter() - begin))
    if np.asarray(wavelength_nm).ndim == 0:
        return parts[0]
    return Rendering(
        image=np.stack([part.image for part in parts]),
        error_estimate=max(part.error_estimate for part in parts),
        checked_photosites=sum(part.checked_photosites for part in parts),
        seconds=sum(part.seconds for part in parts),
        method=parts[0].method,
        tolerance=allowed,
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
    take: Take | None = None,
    progress: Report | None = None,
) -> Rendering:
    """Render every photosite in the channel assigned to it, integrated over the wavelengths.

    response      : (channels, n) signal of a perfect diffuser, quadrature weight included (electrons, or 1)
    wavelength_nm : (n,)
    channel       : (rows, cols) index of each photosite's channel
    every_channel : fill ``planes`` too; ``image`` is the same to the last bit either way
    strict        : raise AccuracyError if the error found is larger than ``tolerance``
    prune         : False also computes, with the same settings, what is not needed: every channel everywhere, edges
                    with equal sides, and edges dropped because they add less than their share of the tolerance
    take          : is called with the image band by band, from the top, and the image returned has no rows; methods
                    that finish all rows together pass one band. The error is known after the last band
    progress      : called with ("render", fraction done)
    returns       : image in the unit of ``response``
    """
    begin = time.perf_counter()
    choice = plan_render(
        scene,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=tolerance,
        method=method,
        samples=samples,
    )
    rendering = carry_out(
        choice, channel, every_channel=every_channel, prune=prune, strict=strict, take=take, progress=progress
    )
    return dataclasses.replace(rendering, seconds=time.perf_counter() - begin)


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
    arrangement: Arrangement | None = None,
) -> Choice:
    """Plan a rendering without carrying it out; arguments as in ``render_channels``.

    arrangement : the scene's arrangement, if it is known already
    """
    check_method(method)
    _check(system, grid, wavelength_nm, tolerance, method)
    if not np.isfinite(response).all():
        raise InvalidValueError("not all of it is finite; give less light, or a shorter exposure", key="response")
    system, grid = _level(system, grid)
    edges = scene.framed(scene.background)
    share = edges_share(scene)
    if arrangement is None:
        seen_nm = wavelength_nm[carrying(response)]
        budget = ErrorBudget(share * tolerance)
        arrangement = arranged(edges, system, grid, seen_nm, budget, textured=edges is not scene)
    if isinstance(system.lens, Varies):
        from camsim.rendering.varying import choose_varying

        return choose_varying(
            scene, edges, arrangement, system, grid, response=response, wavelength_nm=wavelength_nm, share=share,
            tolerance=tolerance, method=method,
        )  # fmt: skip
    job = Job.of(
        edges,
        arrangement,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        tolerance=share * tolerance,
    )
    if edges is scene:
        return choose(method, job, samples)
    fields = FieldJob.of(
        scene,
        system,
        grid,
        response=response,
        wavelength_nm=wavelength_nm,
        scale=job.signals.scale,
        tolerance=max((1.0 if share == 1.0 else 1.0 - share) * tolerance, FINEST),
    )
    # Band and levels are common to edges and fields. Tables and mixtures of fields come on top, at half the tolerance:
    # the outlines' preparation, also at half, leaves room for them.
    job = job.to(tolerance)
    return choose(method, job, samples, scene=scene, fields=fields if fields.layers else None)


def _level(system: OpticalSystem, grid: Grid) -> tuple[OpticalSystem, Grid]:
    """Return the system without its tilt, and a grid that is displaced instead.

    A photosite at x with the PSF p(x − d) has the same value as one at x − d with the PSF p.
    """
    level, moved_um = system.without_tilt()
    return level, grid.behind(moved_um)


def _refuse_too_many(grid: Grid, images: int) -> None:
    """Refuse images that exceed the memory; stacking several needs copies."""
    needed = grid.rows * grid.cols * (IMAGE_BYTES + 16.0 * (images if images > 1 else 0))
    if message := too_large(grid.rows, grid.cols, needed):
        raise InvalidValueError(f"{message}; render fewer at a time, by origin and frame", key="grid")


def _check(system: OpticalSystem, grid: Grid, wavelength_nm: F64, tolerance: float, method: str) -> None:
    if not 0.0 < tolerance <= LOOSEST:
        raise InvalidValueError(f"{tolerance!r} is no error to keep below; give 1e-2 … 1e-11", key="tolerance")
    for w in (wavelength_nm.min(), wavelength_nm.max()):
        if not (math.isfinite(w) and w > 0):
            raise InvalidValueError(f"{float(w)!r} is not a wavelength; give nm above 0", key="wavelength_nm")
    one = [(stage, getattr(stage, "place", "optics")) for stage in system.stages]
    for stage, key in one:
        check_transfer(stage, key, wavelength_nm[:1])  # before its cut-off is computed
    check_lengths(system, wavelength_nm)
    highest_per_um = float(np.max(system.highest_per_um(wavelength_nm)))
    for stage, key in one:
        check_transfer(stage, key, wavelength_nm, highest_per_um)
    check_declared(system, wavelength_nm, tolerance)
    if method not in rules.METHODS:
        check_scales(system, grid, wavelength_nm)
