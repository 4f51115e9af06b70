"""How edges and pictures share a tolerance: all that a scene without pictures takes of this folder."""

from __future__ import annotations

from camsim.scene import Scene
from camsim.scene.raster import Field

OF_EDGES = 0.5  # of the tolerance, where there are pictures too


def edges_share(scene: Scene) -> float:
    """Return the share of the tolerance that edges may take: all of it, but where both are there."""
    pictures = sum(isinstance(shape, Field) for shape in scene.shapes)
    return 1.0 if not pictures else OF_EDGES if pictures < len(scene.shapes) else 1.0
