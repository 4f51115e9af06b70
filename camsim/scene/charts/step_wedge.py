"""A wedge of grey steps: tone curves and noise by level."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le, MinLen

from camsim.core.typed import Fraction, Point, Positive, Several
from camsim.scene.charts.chart import Card, chart, counted, instead, with_densities
from camsim.scene.primitives import Shape
from camsim.spectra.curve import Reflectance


@chart
@instead(densities=("steps", "scale", "darkest", "lightest"))
def step_wedge(
    *,
    width_um: Positive,
    height_um: Positive,
    steps: Annotated[int, Ge(2), Le(100_000)] | None = None,
    scale: Literal["linear", "log"] = "linear",
    darkest: Fraction = 0.02,
    lightest: Fraction = 0.9,
    densities: Annotated[Several[Annotated[float, Ge(0), Le(15)]], MinLen(1)] | None = None,
    rotate_deg: float = 0.0,
    light: Reflectance | None = None,
    centre_um: Point = (0.0, 0.0),
) -> Iterator[Shape]:
    """Draw steps from dark at the left to light at the right, or in the order of their densities.

    width_um, height_um : size of the whole wedge
    steps     : number of steps; 12 when left out
    scale     : linear: equal steps of reflectance; log: equal steps of density
    darkest, lightest : reflectances of the first and the last step
    densities : instead: density of each step, from left to right; a density D is a reflectance of 10^−D

    >>> [step.reflectance for step in step_wedge(width_um=90.0, height_um=30.0, densities=[2.0, 1.0, 0.0]).shapes]
    [0.01, 0.1, 1.0]
    """
    if densities is not None:
        levels = 10.0 ** -np.array(densities)
    else:
        count = 12 if steps is None else steps
        if scale == "log":
            with_densities(step_wedge, darkest=darkest, lightest=lightest)
        levels = (np.geomspace if scale == "log" else np.linspace)(darkest, lightest, count)
    counted(step_wedge, "steps", len(levels))
    card = Card(centre_um, rotate_deg)
    margin = 0.5 * min(width_um, height_um)
    yield from card.behind(width_um + margin, height_um + margin, light)
    sides_um = [width_um * (index / len(levels) - 0.5) for index in range(len(levels) + 1)]
    for index, level in enumerate(np.clip(levels, 0.0, 1.0).tolist()):
        yield card.cell(sides_um[index], -0.5 * height_um, sides_um[index + 1], 0.5 * height_um, level)
