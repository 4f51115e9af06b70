"""The right number in every photosite, and how sure of it we are."""

from camsim.rendering.grid import Grid
from camsim.rendering.kernels import kernels_compiled
from camsim.rendering.render import Rendering, render, render_bands, render_channels

__all__ = ["Grid", "Rendering", "kernels_compiled", "render", "render_bands", "render_channels"]
