"""A choice for the edges of a scene and the pictures in it made one."""

from __future__ import annotations

import dataclasses

from camsim.errors import UnsupportedError
from camsim.rendering.auto import FOURIER, Choice, judge_of
from camsim.rendering.check.judge import Judge
from camsim.rendering.check.pictures import PictureJudge
from camsim.rendering.fields.job import FieldJob
from camsim.rendering.fields.share import edges_share
from camsim.rendering.fourier.task import FINEST
from camsim.rendering.paper import rules
from camsim.scene import Scene


def with_pictures(choice: Choice, scene: Scene, tolerance: float) -> Choice | None:
    """Return the choice for a scene with pictures; ``choice``: for its edges. None where all pictures are hidden.

    tolerance : of both together
    """
    if choice.method in rules.METHODS:
        raise UnsupportedError(
            f"{choice.method} renders shapes, and no pictures or points; use fourier, boundary or auto", key="method"
        )
    job = choice.plan.job
    lone = edges_share(scene) == 1.0
    fields = FieldJob.of(
        scene,
        job.system,
        job.grid,
        response=job.response,
        wavelength_nm=job.wavelength_nm,
        scale=job.signals.scale,
        tolerance=tolerance if lone else max(tolerance - job.tolerance, FINEST),
    )
    if not fields.layers:
        # Where the check sees some all the same, it is to say so.
        sees = PictureJudge(edges=Judge(job, FOURIER), scene=scene, fields=fields)
        return dataclasses.replace(choice, judge=sees) if sees.sees else None
    from camsim.rendering.waves.plan import Waves

    judge = judge_of(job, tolerance, scene) or PictureJudge(edges=Judge(job, FOURIER), scene=scene, fields=fields)

    whole = dataclasses.replace(job, tolerance=tolerance)
    plan = Waves().plan(whole, fields=fields)
    choice = dataclasses.replace(choice, method="fourier")
    if lone:
        return dataclasses.replace(choice, method="fourier", why="pictures are rendered by it", plan=plan, judge=judge)
    return dataclasses.replace(choice, plan=plan, judge=judge)
