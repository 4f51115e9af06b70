"""Shapes of drawings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from camsim.scene.primitives import FillRule
from camsim.scene.shapes import Group, Path
from camsim.scene.svg.outline import IDENTITY, Matrix, Segment
from camsim.spectra.curve import Spectrum


def path(segments: Sequence[Segment], rule: str, reflectance: Spectrum, matrix: Matrix) -> Any:
    """Return a filled path under a transform."""
    fill_rule: FillRule = "evenodd" if rule == "evenodd" else "nonzero"
    filled = Path(segments_um=segments, fill_rule=fill_rule, reflectance=reflectance)
    return placed(filled, matrix)


def placed(shape: Any, matrix: Matrix) -> Any:
    """Return a shape under a transform."""
    return shape if matrix == IDENTITY else Group(shapes=[shape], matrix=matrix)
