"""What the Fourier engine takes, seconds of one core, measured."""

from __future__ import annotations

PER_TILE, PER_CLAMPED = 2e-3, 5e-9  # and of an edge of the scene in each
PER_EDGE_POINT, PER_EDGE_ROW = 0.95e-9, 5e-8  # and of a frequency for each spectrum: that an edge has, and of all
PER_EDGE_SUM, PER_EDGE_SPECTRUM, PER_SPECTRUM_POINT = 2.2e-10, 5e-12, 2.2e-9
PER_ROUND_POINT, PER_FIELD_POINT, PER_POINT_WEIGHT = 1e-9, 3e-8, 8e-9
PER_SPREAD_NODE, PER_SPREAD_POINT = 1.5e-7, 8e-8
PER_GRID_POINT, PER_KERNEL_SAMPLE = 1.2e-8, 4.5e-9
PER_PATTERN_BLUR = 7e-7  # of a round pattern's radius, at one wavelength, the choice of it included
PER_PATTERN = 6e-4  # of one wavelength on a lattice, however few samples it has
PER_PUPIL_NODE = 2.5e-7
PER_LINE, PER_LINE_NODE = 1.2e-3, 1.4e-7  # of a round pattern that is summed over a pupil, at one wavelength
PER_SUMMED_SAMPLE, PER_PUPIL_SAMPLE = 1.5e-7, 4.5e-8  # of a pattern by a non-uniform transform, or on its band's grid
PER_ROUND_SAMPLE = 5.5e-8  # of a pattern that is known along its radius
PER_JOINT_POINT, PER_JOINT_NODE = 1.2e-8, 2e-7  # of a footprint that is no product, and where it is asked for
