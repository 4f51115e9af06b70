"""Rendering of a scene through optics onto a grid of photosites, with an estimate of the error."""

from camsim.rendering.first_use import compile_kernels, kernels_compiled
from camsim.rendering.grid import Grid
from camsim.rendering.render import render, render_channels
from camsim.rendering.running import Rendering

__all__ = ["Grid", "Rendering", "compile_kernels", "kernels_compiled", "render", "render_channels"]
