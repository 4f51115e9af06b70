"""The right number in every photosite, and how sure of it we are."""

from camsim.render.grid import Grid
from camsim.render.kernels import kernels_compiled
from camsim.render.rendering import Rendering, render, render_channels

__all__ = ["Grid", "Rendering", "kernels_compiled", "render", "render_channels"]
