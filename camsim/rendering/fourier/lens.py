"""The lens as the Fourier engine multiplies by it: its transfer after the taper, a curve if it is round, or a field.

A round lens is tapered in the plane and projected on a line: by the projection theorem the projection's cosine
transform is the plane's transform along any direction. Both sums are trapezoidal and as good as exact, because the
tapered pattern is band-limited. Any other lens is sampled on a lattice: see sampled_lens.py.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
import scipy

from camsim.arrays import C128, F64
from camsim.kernels import kernel, shared
from camsim.optics import OpticalSystem, RoundLens
from camsim.optics.protocols import Fading, KnowsEnergy, KnowsNodes, KnowsReach, KnowsTail, Round, Separable
from camsim.quadrature import chebyshev, interpolation
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fourier.blocks import Block, Tile
from camsim.rendering.fourier.kernels import Curves, Factors
from camsim.rendering.fourier.plan import Kernel, Sizes
from camsim.rendering.fourier.taper import taper, tapered
from camsim.rendering.psf import rule_of

SAMPLES, CELLS = 20, 4  # points of a pattern on its own length: 7e-15; it is interpolated on quarters of that:
DEGREE = 11  # of the pattern on a quarter of its own length: 6e-14
OVERSAMPLED = 16  # of the transfer's curve; with 8 points 2.4e-9 of what oscillates fastest, which is the faintest
CURVE_POINTS = 8


def kernel_of(system: OpticalSystem, wavelength_nm: F64, pitch_um: float, tolerance: float) -> Kernel:
    """Return what the plan has to know of the lens at these wavelengths."""
    lens, more = system.lens, system.more
    cutoff = system.highest_per_um(wavelength_nm) * pitch_um
    blur = float(system.blurs_um(wavelength_nm).min()) / pitch_um
    reach = math.inf
    if isinstance(lens, KnowsTail):
        lost, heard = ErrorBudget(tolerance).allowed("reach"), system.ring_share(wavelength_nm)
        ends_nm = {float(wavelength_nm.min()), float(wavelength_nm.max())}
        reach = max(lens.reach_um(lost, nm, heard) for nm in ends_nm) / pitch_um
    elif len(known := [stage for stage in (lens, *more) if isinstance(stage, KnowsReach)]) == 1 + len(more):
        # What one blur takes to its reach, the next takes on from there.
        lost = ErrorBudget(tolerance).allowed("reach") / len(known)
        reach = max(sum(float(stage.reach_um(lost, nm)) for stage in known) for nm in wavelength_nm.tolist()) / pitch_um
    is_round = isinstance(lens, Round) and not more
    faint = isinstance(lens, Fading) and lens.fades and not more
    rings: tuple[tuple[float, float], ...] = ()
    if is_round and not faint and isinstance(lens, RoundLens):
        longest = float(system.blurs_um(wavelength_nm).max()) / pitch_um
        # Twice for a whole line, twice for the taper's step in what does not oscillate, four times to be sure:
        # with 4 in place of 16 random polygons came to 0.7 of the tolerance.
        rings = tuple((16.0 * a * longest**n, n) for _, a, n in lens.pattern().rings)
    return Kernel(
        cutoff=cutoff,
        blur=blur,
        reach=reach,
        round=is_round,
        tapered=not faint,
        light=_light_beyond(system, wavelength_nm, pitch_um),
        pupil_nodes=_pupil_nodes(system, wavelength_nm, pitch_um),
        rings=rings,
    )


def _pupil_nodes(system: OpticalSystem, wavelength_nm: F64, pitch_um: float) -> Callable[[float], float]:
    """Return what tells how many nodes the patterns at all wavelengths take out to a distance in pitches."""
    lens = system.lens
    if not isinstance(lens, KnowsNodes) or system.more:
        cutoffs = [system.cutoff_per_um(nm) * pitch_um for nm in wavelength_nm.tolist()]
        return lambda distance: float(sum(math.prod(rule_of(cutoff * distance)) for cutoff in cutoffs))
    each = [lens.pupil_nodes(float(w)) for w in wavelength_nm]
    return lambda distance: sum(nodes(distance * pitch_um) for nodes in each)


def _light_beyond(system: OpticalSystem, wavelength_nm: F64, pitch_um: float) -> Callable[[float], float]:
    """Return what tells how much light may lie beyond a distance in pitches: all of it where the lens does not say.

    A pattern may have dark rings: what lies beyond is looked for farther out too, and taken twice. A radial curve may
    have negative ones: they count as much as the others.
    """
    lens = system.lens
    ends_nm = {float(wavelength_nm.min()), float(wavelength_nm.max())}
    if isinstance(lens, KnowsTail):
        tail, rings = lens.light_beyond, system.ring_share(wavelength_nm)
        return lambda distance: min(
            1.0, 2.0 * max(float(tail(np.array(distance * pitch_um), nm, rings)) for nm in ends_nm)
        )
    if not isinstance(lens, KnowsEnergy) or system.more:
        return lambda distance: 1.0
    if isinstance(lens, RoundLens) and lens.pattern().signed:
        pattern, blurs = lens.pattern(), [system.blur_um(nm) / pitch_um for nm in ends_nm]
        return lambda distance: max(pattern.absolute(distance / blur) for blur in blurs)
    energy = lens.encircled_energy
    farther = np.linspace(1.0, 1.5, 33)

    def light(distance: float) -> float:
        radius_um = distance * pitch_um * farther
        return min(1.0, 2.0 * max(float(np.abs(1.0 - energy(radius_um, nm)).max()) for nm in ends_nm))

    return light


@kernel()
def _project(
    cells: F64, cells_per_length: float, outer: float, step_x: float, step_y: float, out: F64, begin: int, end: int
) -> None:
    """Fill in some of (count, columns): Σ over y of a round pattern, at x = 0, step_x, …

    cells : (cells, DEGREE + 1, columns) its monomials on −1 … 1 of every cell
    """
    for i in range(begin, end):
        x = i * step_x
        deepest = int(math.sqrt(max(outer * outer - x * x, 0.0)) / step_y)
        for m in range(deepest + 1):
            y = m * step_y
            place = math.sqrt(x * x + y * y) * cells_per_length
            cell = min(int(place), len(cells) - 1)
            t = 2.0 * (place - cell) - 1.0
            share = step_y if m == 0 else 2.0 * step_y
            for q in range(out.shape[1]):
                value = cells[cell, DEGREE, q]
                for d in range(DEGREE - 1, -1, -1):
                    value = value * t + cells[cell, d, q]
                out[i, q] += share * value


def round_curves(
    lens: Round,
    wavelength_nm: F64,
    weights: F64,
    pitch_um: float,
    kernel: Kernel,
    tile: Tile,
    plan: Sizes,
) -> Curves:
    """Return the transfer of a round lens over |k|: coefficients of t⁰ … t⁷ on 0 ≤ t < 1 in every cell.

    weights : (spectra, channels, j)
    """
    inner, outer = tile.inner[0], tile.outer[0]
    flat = weights.reshape(-1, wavelength_nm.size)
    lengths = math.ceil(outer / kernel.blur)
    count = CELLS * lengths
    sampled = chebyshev(SAMPLES)
    radius = (np.arange(lengths)[:, None] + 0.5 * (1.0 + sampled)) * (outer / lengths)
    values = np.zeros((lengths, SAMPLES, len(flat)))
    for j, wavelength in enumerate(wavelength_nm):
        pattern = lens.point_spread(radius * pitch_um, float(wavelength)) * pitch_um**2
        values += pattern[..., None] * flat[:, j]
    x = chebyshev(DEGREE + 1)
    within = (2.0 * np.arange(CELLS)[:, None] + 1.0 + x).ravel() / CELLS - 1.0
    values = np.einsum("fx,lxq->lfq", interpolation(sampled, within), values).reshape(count, DEGREE + 1, len(flat))
    radius = (np.arange(count)[:, None] + 0.5 * (1.0 + x)) * (outer / count)
    values *= tapered(radius, inner, outer, taper(plan.sharpness))[..., None]
    # Not by matrix products: a BLAS with threads of its own would keep the cores from the kernels for milliseconds.
    cells = np.einsum("dx,cxq->cdq", np.linalg.inv(np.vander(x, increasing=True)), values)

    step_x, step_y = 0.49 / tile.cut, 0.97 / tile.cut
    samples = math.ceil(outer / step_x) + 1
    line = np.zeros((samples, len(flat)))
    shared(samples, functools.partial(_project, cells, count / outer, outer, step_x, step_y, line))
    length = scipy.fft.next_fast_len(max(1024, OVERSAMPLED * samples), real=True)
    padded = np.zeros((len(flat), length + 1))
    padded[:, :samples] = line.T
    transfer = scipy.fft.dct(padded, type=1, axis=1) * step_x
    whole = np.concatenate([transfer[:, 3:0:-1], transfer], axis=1)
    cells_per_frequency = 2.0 * length * step_x
    used = math.ceil(tile.cut * cells_per_frequency) + 1
    window = np.lib.stride_tricks.sliding_window_view(whole[:, : used + CURVE_POINTS - 1], CURVE_POINTS, axis=1)
    curves = np.einsum("qcx,dx->cqd", window, _THROUGH)
    return Curves(curves.reshape(-1, *weights.shape[:2], CURVE_POINTS), cells_per_frequency)


# Rows: coefficients of t^0 … t^7 of the polynomial through values at −3 … 4.
_THROUGH = np.linalg.inv(np.vander(np.arange(-3.0, 5.0), CURVE_POINTS, increasing=True))

Fields = Callable[[Block], F64]


def plain_fields(system: OpticalSystem, wavelength_nm: F64, pitch_um: float, tile: Tile) -> Fields:
    """Return what gives the transfer of a lens whose pattern dies away by itself: block → (wavelengths, j, i, 2)."""

    def fields(block: Block) -> F64:
        fx, fy = frequencies(block, tile, pitch_um)
        out = np.empty((wavelength_nm.size, block.count_j, block.count_i), complex)
        for j, wavelength in enumerate(wavelength_nm):
            out[j] = system.lens.otf(fx, fy, float(wavelength))
        return parts(out)

    return fields


def frequencies(block: Block, tile: Tile, pitch_um: float) -> tuple[F64, F64]:
    """Return the block's fx (1, count_i) and fy (count_j, 1), cycles/µm."""
    fx = (block.first_i + np.arange(block.count_i)) / (tile.periods[0] * pitch_um)
    fy = (block.first_j + np.arange(block.count_j)) / (tile.periods[1] * pitch_um)
    return fx[None], fy[:, None]


def footprint_transfer(system: OpticalSystem, block: Block, tile: Tile, pitch_um: float) -> Factors:
    """Return the transfer of OLPF and photosite on a block."""
    fx, fy = frequencies(block, tile, pitch_um)
    zero = np.zeros((1, 1))
    across, down = np.ones(fx.shape, complex), np.ones(fy.shape, complex)
    both = np.empty((0, 0), complex)
    for stage in (system.olpf, system.photosite):
        if stage is None:
            continue
        if isinstance(stage, Separable) and stage.separable:
            across *= stage.otf(fx, zero, 0.0)
            down *= stage.otf(zero, fy, 0.0)
        else:
            values = np.broadcast_to(stage.otf(fx, fy, 0.0), (block.count_j, block.count_i))
            both = both * values if both.size else values.astype(complex)
    return Factors(across=parts(across.ravel()), down=parts(down.ravel()), both=parts(both))


def parts(values: C128) -> F64:
    """Return complex numbers as real and imaginary part, along a last axis."""
    return np.ascontiguousarray(values).view(np.float64).reshape(*values.shape, 2)
