"""The right number in every photosite, and how sure of it we are."""

from camsim.rendering.grid import Grid
from camsim.rendering.render import kernels_compiled, render, render_channels
from camsim.rendering.running import Rendering

__all__ = ["Grid", "Rendering", "kernels_compiled", "render", "render_channels"]
