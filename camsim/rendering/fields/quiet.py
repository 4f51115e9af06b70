"""How far the pattern is taken as it is, ring by ring, before its rings are averaged."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.optics.protocols import KnowsTail
from camsim.rendering.budget import ErrorBudget
from camsim.rendering.fields.cost import STRIP_POINTS
from camsim.rendering.fields.layer import Layer
from camsim.rendering.fields.points import PointLayer
from camsim.rendering.fourier.plan import BLOCK_POINTS, FEWEST_IN_BLOCK, Sizes
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.swings import swings
from camsim.rendering.fourier.taper import taper_margin
from camsim.rendering.fourier.tile import Tile

DIRECTIONS = 64
STEPS = 1.2  # of the search for the inner radius
IN_STEP_UP_TO, IN_STEP_PLACES = 1.5, 96  # where rings are listened to beyond it


# A tail of r⁻⁵ has 3π/2 times as much light beyond a distance as a straight edge there shows.
OF_AN_EDGE = 5.0


def for_pictures(
    kernel: Kernel, system: OpticalSystem, wavelength_nm: F64, pitch_um: float, budget: ErrorBudget, rings_until: float
) -> Kernel:
    """Return what is known of a lens, for pictures: of one that tells what edges hear of its light they hear more.

    rings_until : as in ``FieldImage``
    """
    lens = system.lens
    if not isinstance(lens, KnowsTail):
        return kernel
    lost, heard = budget.allowed("cut") / OF_AN_EDGE, system.ring_share(wavelength_nm)
    ends_nm = {float(wavelength_nm.min()), float(wavelength_nm.max())}
    return dataclasses.replace(
        kernel,
        reach=max(rings_until, max(lens.reach_um(lost, nm, heard) for nm in ends_nm) / pitch_um),
        light=lambda distance: min(1.0, OF_AN_EDGE * kernel.light(distance)),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """The pattern parted, pitches: whole within ``inner``, nothing beyond ``outer``; ``far``: whether a rest is."""

    inner: tuple[float, float]
    outer: tuple[float, float]
    margin: float
    sharpness: float
    far: bool

    @property
    def band(self) -> float:
        """How far the taper's transform reaches, cycles/pitch."""
        width = self.outer[0] - self.inner[0]
        return self.margin / width if width else 0.0

    def sizes(self, tile: Tile, planes: int, channels: int, fields: int, pattern_rows: int) -> Sizes:
        """Return the settings of one window's transforms.

        fields : transfers that are held for a block;  pattern_rows: that are made at a time
        """
        return Sizes(
            tiles=(tile,),
            spread=True,
            channels=channels,
            fields=fields,
            block_points=max(FEWEST_IN_BLOCK, 6 * BLOCK_POINTS // (6 + planes + fields)),
            strip_points=STRIP_POINTS,
            pattern_rows=pattern_rows,
            seconds=0.0,
            memory_bytes=0.0,
        )


def parted(
    kernel: Kernel,
    extent: F64,
    shape: tuple[int, int],
    allowed: float,
    quiet: Callable[[float], float] | None,
) -> Reach:
    """Return how the pattern is parted for a window.

    extent  : (2,) how far apart photosites and pictures lie;  shape: rows and columns
    allowed : what the taper may be wrong by;  quiet: distance where the pattern turns quiet, within what is given
    """
    if not kernel.tapered:
        whole = (kernel.reach, kernel.reach)
        return Reach(inner=whole, outer=whole, margin=0.0, sharpness=0.0, far=False)
    span = float(np.hypot(*extent))
    inner = np.full(2, min(kernel.reach, span)) if kernel.round else np.minimum(extent, kernel.reach)
    nearer = span if quiet is None else quiet(span)
    far = quiet is not None and nearer < float(inner[0])
    if far:
        inner = np.full(2, nearer)
    level = allowed / min(1.0, kernel.light(float(inner.min())))
    margin, sharpness = taper_margin(min(max(level, 1e-14), 1.0))
    period = float(max(shape)) + 2.0 * float(inner.max()) if far else float(extent.max() + inner.max())
    width = max(math.sqrt(margin * period / kernel.cutoff), margin * kernel.blur / 8.0)
    if far:
        # Narrower than would be best for the near part alone: but the wider, the coarser the far part's lattice.
        width = min(width, max(float(inner[0]), margin * kernel.blur / 8.0))
    outer = inner + width
    return Reach(
        inner=(float(inner[0]), float(inner[1])),
        outer=(float(outer[0]), float(outer[1])),
        margin=margin,
        sharpness=sharpness,
        far=far,
    )


def quiet_distance(
    layers: Sequence[Layer | PointLayer],
    system: OpticalSystem,
    wavelength_nm: F64,
    density: F64,
    pitch_um: float,
    kernel: Kernel,
    footprint: float,
    within: float,
    *,
    allowed: float,
) -> float:
    """Return the distance from which on the pattern's rings may be averaged.

    A picture hears them by what it has at the frequency of the rings, the cut-off; at most all of the light beyond
    times what samples and footprint leave of that frequency, in the mean over directions. Sharp outlines have all
    frequencies, and hear as much as any edge.
    """
    sides = sum(layer.sides for layer in layers)
    pointed = [layer.loud for layer in layers if isinstance(layer, PointLayer)]
    ends_nm = float(wavelength_nm.min()), float(wavelength_nm.max())
    heard = max(heard_by(layers, system, pitch_um, pitch_um / system.blur_um(nm)) for nm in ends_nm)
    blur = system.blurs_um(wavelength_nm) / pitch_um
    longest = float(blur.max())
    # What is heard of the pattern's own, the fastest, is in ``heard``.
    rings = [
        (ring, heard_by(layers, system, pitch_um, ring.f) if ring.f * longest < 1.0 else 0.0)
        for ring in swings(system, longest)
    ]
    sharpness = taper_margin(min(allowed, 1.0))[1]
    distance = max(4.0 * footprint, 8.0 / kernel.cutoff, 12.0)
    while distance < within:
        by_edges = sides * sum(a * distance**-n for a, n in kernel.rings) if kernel.rings else math.inf
        # Slower rings are heard more; and a taper as wide as it begins far out may be short for them.
        cut = (ring.light(distance) * part + ring.left(distance, distance, sharpness) for ring, part in rings)
        loud = max(kernel.light(distance) * heard, by_edges, max(cut, default=0.0))
        if pointed:
            # An edge hears of a point's rings what lies in step along it, √(λN·R), for λN/2π across.
            from_line = sum(a * distance**-n for a, n in kernel.rings) if kernel.rings else math.inf
            loud = max(loud, min(1.0, sum(pointed)) * from_line * 2.0 * math.pi / math.sqrt(kernel.blur**3 * distance))
        if loud <= allowed or loud * _in_step(blur, density, distance) <= allowed:
            break
        distance *= STEPS
    return distance


def heard_by(layers: Sequence[Layer | PointLayer], system: OpticalSystem, pitch_um: float, f: float) -> float:
    """Return what samples and footprint leave of a ring of f cycles/pitch, in the mean over directions, at the most."""
    angle = 2.0 * np.pi * (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    kx, ky = f * np.cos(angle), f * np.sin(angle)
    passed, heard = np.abs(system.footprint_otf(kx / pitch_um, ky / pitch_um)), 0.0
    for layer in layers:
        if not isinstance(layer, PointLayer):
            along = [layer.step * (x * kx + y * ky) for x, y in layer.axes]
            heard = max(heard, float(np.mean(passed * np.abs(np.sinc(along[0]) * np.sinc(along[1])))))
    return heard


def _in_step(blur: F64, density: F64, distance: float) -> float:
    """Return how much of the rings' light at all wavelengths adds up from a distance on; ``blur``: (j,) pitches."""
    radius = distance * np.linspace(1.0, IN_STEP_UP_TO, IN_STEP_PLACES)
    turns = np.exp(2j * np.pi * radius[:, None] / blur)
    flat = density.reshape(-1, blur.size)
    together = np.abs(np.einsum("qj,rj->qr", flat.astype(complex), turns)).max(axis=1)
    return float(np.minimum(together.max(), 1.0))
