"""What a measurement of places returns: frozen, every name with its unit."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import F64
from camsim.measure.full_frame import FullFrame

_UNTOLD = 1e-9
"""Of what the marks tell best: what they tell less well is not told."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkPlace:
    """One dot or corner in one channel; pixels from the optical axis, right and down.

    x_pixel, y_pixel               : where the scene has it
    dx_pixel, dy_pixel             : by how much it is seen farther to the right and farther down
    error_pixel                    : standard error of each of the two
    theory_dx_pixel, theory_dy_pixel : dx and dy by the lens that the picture was taken with
    """

    channel: str
    x_pixel: float
    y_pixel: float
    dx_pixel: float
    dy_pixel: float
    error_pixel: float
    theory_dx_pixel: float
    theory_dy_pixel: float

    @property
    def radius_pixel(self) -> float:
        """Distance from the axis."""
        return math.hypot(self.x_pixel, self.y_pixel)

    @property
    def radial_pixel(self) -> float:
        """The displacement away from the axis."""
        return self._outwards(self.dx_pixel, self.dy_pixel)

    @property
    def theory_radial_pixel(self) -> float:
        """The same by theory."""
        return self._outwards(self.theory_dx_pixel, self.theory_dy_pixel)

    def _outwards(self, dx: float, dy: float) -> float:
        radius = self.radius_pixel
        return (dx * self.x_pixel + dy * self.y_pixel) / radius if radius else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """Displacements of marks, and the polynomial through them.

    A mark at (x, y) is displaced by shift + (x, y)·(scale − 1 + k1·r² + k2·r⁴), r in half diagonals of the full frame.

    shift_x_pixel, shift_y_pixel : of the whole picture
    scale       : 1 where the image is as large as the scene says
    k1, k2      : radial distortion; negative: barrel
    largest_distortion : k1·r² + k2·r⁴ at the farthest mark, a fraction of its radius; the sign says which way
    rms_pixel   : of what the polynomial leaves
    lateral_rms_pixel, lateral_largest_pixel : distance to the same marks in the reference channel; None in that one
    """

    shift_x_pixel: float
    shift_y_pixel: float
    scale: float
    k1: float
    k2: float
    largest_distortion: float
    rms_pixel: float
    lateral_rms_pixel: float | None
    lateral_largest_pixel: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class DisplacementError:
    """Standard errors of the polynomial's figures, by what it leaves; NaN where the marks do not tell a figure."""

    shift_x_pixel: float
    shift_y_pixel: float
    scale: float
    k1: float
    k2: float
    largest_distortion: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelDistortion(Displacement):
    """What is measured in one channel.

    standard_error       : of the figures of the polynomial
    theory               : the same figures of the same marks, by the lens that the picture was taken with
    off_theory_rms_pixel : distance of the marks to where that puts them
    """

    channel: str
    marks: tuple[MarkPlace, ...]
    standard_error: DisplacementError
    theory: Displacement
    off_theory_rms_pixel: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DistortionReport:
    """All channels of one picture.

    kind      : the chart whose marks were found
    reference : the channel that lateral colour is counted from
    left_out  : a sentence for marks that could not be measured
    """

    file: str
    kind: str
    full_frame: FullFrame
    reference: str
    channels: tuple[ChannelDistortion, ...]
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            "file": self.file,
            "chart": self.kind,
            "pitch_um": self.full_frame.pitch_um,
            "half_diagonal_pixel": half_diagonal_pixel(self.full_frame),
            "reference": self.reference,
            "channels": [_plain(asdict(channel)) for channel in self.channels],
            "left_out": list(self.left_out),
        }


def half_diagonal_pixel(frame: FullFrame) -> float:
    """Return the radius that counts as 1."""
    return 0.5 * math.hypot(frame.rows, frame.cols)


def _plain(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tree with None for errors that are not known, which JSON has no number for."""
    errors = {key: value if math.isfinite(value) else None for key, value in tree["standard_error"].items()}
    return tree | {"standard_error": errors}


def radial_fit(places: F64, moves: F64, half_diagonal: float) -> tuple[F64, F64, F64]:
    """Return shift x, shift y, scale − 1, k1, k2 of displacements (n, 2) by least squares, and what is left (n, 2).

    Last their covariance (5, 5), by what is left; infinite where the marks tell nothing.
    """
    x, y, dx, dy = *places.T, *moves.T
    r2 = (x * x + y * y) / half_diagonal**2
    one, none = np.ones_like(x), np.zeros_like(x)
    system = np.concatenate(
        [
            np.stack([one, none, x, x * r2, x * r2**2], axis=1),
            np.stack([none, one, y, y * r2, y * r2**2], axis=1),
        ]
    )
    move = np.concatenate([dx, dy])
    u, sizes, ways = np.linalg.svd(system, full_matrices=False)
    # Marks that all lie near the axis tell no powers: those stay 0.
    stated = sizes > _UNTOLD * sizes[0]
    inverse = np.where(stated, 1.0 / np.where(stated, sizes, 1.0), 0.0)
    solved = np.einsum("ji,j,nj,n->i", ways, inverse, u, move, optimize=True)
    left = move - np.einsum("ni,i->n", system, solved)
    freedom = max(move.size - int(np.count_nonzero(stated)), 1)
    covariance = float(left @ left) / freedom * np.einsum("ji,j,jk->ik", ways, inverse**2, ways)
    untold = np.abs(ways[~stated]).max(axis=0, initial=0.0) > _UNTOLD
    covariance[np.ix_(untold, untold)] = math.inf
    return solved, left.reshape(2, -1).T, covariance
