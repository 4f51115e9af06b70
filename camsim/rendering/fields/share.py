"""Shares of the tolerance for edges and pictures; the only module of this folder that a scene of edges imports."""

from __future__ import annotations

from camsim.scene import Scene
from camsim.scene.raster import Field

OF_EDGES = 0.5  # of the tolerance, for a scene with pictures and edges


def edges_share(scene: Scene) -> float:
    """Return the share of the tolerance that edges get: 1, or less if the scene also has pictures."""
    pictures = sum(isinstance(shape, Field) for shape in scene.shapes)
    return 1.0 if not pictures else OF_EDGES if pictures < len(scene.shapes) else 1.0
