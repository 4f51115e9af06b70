"""The check of renderings with a rotationally symmetric lens: photosites recomputed from the scene by direct sums."""

from __future__ import annotations

import functools
import math

import numpy as np

from camsim.core.arrays import F64, I64, U8, kinds_of
from camsim.core.cached import cached_property
from camsim.core.kernels import shared
from camsim.numerics.matrix_products import product
from camsim.numerics.quadrature import gauss_phases, gauss_rules
from camsim.rendering.direct.checks import in_channels
from camsim.rendering.direct.fields import Fields
from camsim.rendering.direct.light import condensed, counted_until, densities
from camsim.rendering.direct.photosites import along_outlines
from camsim.rendering.direct.places import hardest_photosites, how_many
from camsim.rendering.direct.records import Table
from camsim.rendering.direct.scenery import Pieces, pieces_of
from camsim.rendering.direct.spread import Spline, tabled
from camsim.rendering.engine import Plan
from camsim.rendering.job import Job
from camsim.rendering.spectral import carrying
from camsim.scene import Scene
from camsim.scene.arcs import Fineness

OF_TOLERANCE = 0.3  # error of the check over the tolerance
OF_RINGS, OF_TABLE, OF_PANELS, OF_FIELDS = 0.4, 0.4, 0.05, 0.15  # shares of that
OF_CURVES = 1.0  # over that: the bound on the light between a curve and its arcs, which is ten times the light
OF_POINT = 20.0  # times a point's area: error of its light over that of an edge's, from the same rows
MOST_NODES = 24  # of a panel
PIECES_AT_ONCE = 128  # fewer, of all photosites, are not worth a thread
NODES_A_WAVE, FAR_NODES = 3.0, 6.0  # nodes of a piece: per period nearby, and at least
# Of one core: per node and piece, and for a table per square of its radius in periods.
NODE_SECONDS, PIECE_SECONDS, ROW_SECONDS = 3e-8, 1e-5, 1e-6


class DirectCheck:
    """Check that recomputes photosites of a job; ``scene``: the whole scene, as the job's may lack the pictures.

    The check uses only the inputs of the job (scene, optics, grid, light) and nothing derived from them: it computes
    outlines, painter's order, spectra, wavelengths and PSF independently.
    """

    def __init__(self, job: Job, scene: Scene | None = None, tolerance: float | None = None) -> None:
        self.job = job
        self.scene = job.scene if scene is None else scene
        self.allowed = OF_TOLERANCE * (job.tolerance if tolerance is None else tolerance)

    @cached_property
    def _highest(self) -> float:
        """Cut-off frequency of the lens, cycles/pitch."""
        felt_nm = self.job.wavelength_nm[carrying(self.job.response)]
        return self.job.system.highest_per_um(felt_nm) * self.job.grid.pitch_um

    @cached_property
    def _fields(self) -> Fields:
        """Pictures, gradients and points."""
        return Fields(self.scene, self.job.grid.pitch_um, self._highest, OF_FIELDS * self.allowed)

    @cached_property
    def _seen(self) -> tuple[Pieces, F64, F64, F64]:
        """Pieces of outlines with pictures black, wavelengths (n,), and signals of surfaces and of fields there.

        Signals are (spectra, channels, n).
        """
        job = self.job
        fine = Fineness(1.0 / self._highest, OF_CURVES * self.allowed)
        pieces, spectra = pieces_of(self.scene.framed(0.0), job.grid.pitch_um, fine)
        wavelength_nm, density, full = densities(spectra, job.response, job.wavelength_nm)
        of_fields = density[:0]
        if self._fields.spectra:
            of_fields = densities(self._fields.spectra, job.response, job.wavelength_nm, full)[1]
        return pieces, wavelength_nm, density, of_fields

    @cached_property
    def base(self) -> F64:
        """The background in each channel."""
        background: F64 = self._seen[2][0].sum(axis=1)
        return background

    @cached_property
    def _until(self) -> float:
        """Cutoff radius of ringing, pitches."""
        pieces, wavelength_nm, density, of_fields = self._seen
        contrast = np.concatenate([density[1:] - density[0], of_fields])
        return counted_until(
            self.job.system, self.job.grid.pitch_um, wavelength_nm, contrast, pieces, OF_RINGS * self.allowed,
            self._fields.strongest,
        )  # fmt: skip

    @cached_property
    def _light(self) -> tuple[F64, F64]:
        """Wavelength nodes (j,), and the matrix (n, j) that moves signals at all wavelengths to them."""
        wavelength_nm = self._seen[1]
        system, pitch_um = self.job.system, self.job.grid.pitch_um
        if not system.chromatic:
            return wavelength_nm[:1], np.ones((wavelength_nm.size, 1))
        blur = system.blurs_um(np.array([wavelength_nm.min(), wavelength_nm.max()])) / pitch_um
        phase = 2.0 * math.pi * self._until * float(1.0 / blur.min() - 1.0 / blur.max())
        return condensed(wavelength_nm, phase, self.allowed)

    def _tabled(self, spline: Spline | None = None) -> tuple[Table, F64, F64]:
        """Return the table of the PSF, and the weights of its kinds of light in surfaces and in fields.

        Weights are (spectra, channels, kinds) for each spectrum minus the background, and (planes, channels, kinds).
        """
        _, _, density, of_fields = self._seen
        wavelength_nm, matrix = self._light
        of_surfaces, signals = (
            product(one.reshape(-1, len(matrix)), matrix).reshape(*one.shape[:2], matrix.shape[1])
            for one in (density, of_fields)
        )
        if spline is None:
            signals = np.concatenate([of_surfaces - of_surfaces[0], signals])
        table, mixture = tabled(
            self.job.system,
            self.job.grid.pitch_um,
            wavelength_nm,
            signals.reshape(-1, signals.shape[2]),
            until=self._until + (0.0 if spline is None else spline.extent),
            allowed=OF_TABLE * self.allowed / (1.0 + OF_POINT * self._fields.strongest[1]),
            spline=spline,
        )
        mixture = mixture.reshape(*signals.shape[:2], -1)
        surfaces = len(mixture) - len(of_fields)
        return table, mixture[:surfaces], mixture[surfaces:]

    def hardest(self, plan: Plan) -> tuple[I64, I64]:
        """Return rows and columns of the photosites to check."""
        if self._nothing:  # there may be points under shapes
            grid = self.job.grid
            corner = np.array([grid.first_centre])
            places = np.concatenate([corner, self._fields.places(grid, plan.fewest)]) - corner
            cols, rows = np.clip(np.rint(places), 0, np.array([grid.cols, grid.rows]) - 1).astype(np.int64).T
            return rows, cols
        count = self._count(plan)
        more = self._fields.places(self.job.grid, count)
        return hardest_photosites(self._seen[0].outlines, more, self.job.grid, plan.marks, count=count)

    @property
    def _nothing(self) -> bool:
        return not len(self._seen[0].left) and not self._fields.visible

    def _count(self, plan: Plan) -> int:
        """Return how many photosites are checked."""
        return how_many(
            self.job.grid.rows * self.job.grid.cols,
            render_seconds=plan.cost.seconds,
            check_seconds=self._seconds_each,
            fewest=plan.fewest,
        )

    @cached_property
    def _seconds_each(self) -> float:
        """Expected seconds for one photosite."""
        length = self._seen[0].outlines.length
        nodes = NODES_A_WAVE * self._highest * np.minimum(length, 2.0 * self._until) + FAR_NODES
        of_fields = NODE_SECONDS * self._fields.nodes(self._until) if self._fields.visible else 0.0
        return NODE_SECONDS * float(nodes.sum()) + of_fields

    def seconds(self, plan: Plan) -> float:
        """Return the expected seconds of the check."""
        if self._nothing:
            return 0.0
        pieces = PIECE_SECONDS * len(self._seen[0].left)
        return pieces + ROW_SECONDS * (self._until * self._highest) ** 2 + self._count(plan) * self._seconds_each

    def values(self, rows: I64, cols: I64, sets: U8) -> F64:
        """Recompute photosites, each in its channel of ``sets`` (..., photosites)."""
        x0, y0 = self.job.grid.first_centre
        points = np.stack([x0 + cols, y0 + rows], axis=1).astype(float)
        light = self.base + self._of_edges(points)
        if self._fields.visible:
            light = light + self._fields.light(points, len(self.base), self._tabled)
        return in_channels(light.T, sets)

    def _of_edges(self, points: F64) -> F64:
        """Return the light of outlines at points (n, 2) in all channels (n, channels)."""
        pieces, _, density, _ = self._seen
        out = np.zeros((len(points), density.shape[1]))
        if not len(pieces.left):
            return out
        table, of_kinds, _ = self._tabled()
        both, pair = kinds_of(pieces.left * len(density) + pieces.right)
        left, right = np.divmod(both, len(density))
        nodes, weights, _ = gauss_rules(tuple(range(1, MOST_NODES + 1)))
        phases = gauss_phases(OF_PANELS * self.allowed, MOST_NODES)
        work = functools.partial(
            along_outlines, points, pieces.outlines, pieces.outlines.length, pair,
            np.ascontiguousarray(of_kinds[left] - of_kinds[right]), table,
            (nodes, weights, phases, float(phases[-1] / (math.pi * self._highest))), out,
        )  # fmt: skip
        shared(len(points), work, least=-(-PIECES_AT_ONCE // len(pieces.left)))
        return out
