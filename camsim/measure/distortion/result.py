"""Results of a measurement of distortion."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from camsim.core.arrays import F64
from camsim.measure.full_frame import FullFrame

_UNTOLD = 1e-9
"""Least information relative to the best-determined figure; less counts as undetermined."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkPlace:
    """One dot or corner in one channel; pixels from the optical axis, right and down.

    x_pixel, y_pixel               : position of the mark in the scene
    dx_pixel, dy_pixel             : displacement of the mark to the right and down
    error_pixel                    : standard error of each of the two
    theory_dx_pixel, theory_dy_pixel : dx and dy predicted by the lens of the capture
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
        """The displacement away from the axis that theory predicts."""
        return self._outwards(self.theory_dx_pixel, self.theory_dy_pixel)

    def _outwards(self, dx: float, dy: float) -> float:
        radius = self.radius_pixel
        return (dx * self.x_pixel + dy * self.y_pixel) / radius if radius else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Displacement:
    """Displacements of marks, and the polynomial through them.

    A mark at (x, y) is displaced by shift + (x, y)·(scale − 1 + k1·r² + k2·r⁴), r in half diagonals of the full frame.

    shift_x_pixel, shift_y_pixel : shift of the whole picture
    scale       : 1 if the image has the size of the scene
    k1, k2      : radial distortion; negative: barrel
    largest_distortion : k1·r² + k2·r⁴ at the farthest mark, a fraction of its radius; the sign says which way
    rms_pixel   : root mean square residual of the polynomial
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
    """Standard errors of the figures of ``Displacement``, from residuals; NaN where the marks do not determine one."""

    shift_x_pixel: float
    shift_y_pixel: float
    scale: float
    k1: float
    k2: float
    largest_distortion: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelDistortion(Displacement):
    """Distortion of one channel.

    standard_error       : standard errors of the polynomial's figures
    theory               : the same figures of the same marks, predicted by the lens of the capture
    off_theory_rms_pixel : distance of the marks from the predicted positions
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
    reference : the reference channel of lateral colour
    left_out  : a sentence for marks that could not be measured
    """

    file: str
    kind: str
    full_frame: FullFrame
    reference: str
    channels: tuple[ChannelDistortion, ...]
    left_out: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Return the result as plain values for JSON."""
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
    """Return the half diagonal of the frame in pixels, the unit of the polynomial's r."""
    return 0.5 * math.hypot(frame.rows, frame.cols)


def _plain(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tree with None for unknown errors, as JSON has no NaN."""
    errors = {key: value if math.isfinite(value) else None for key, value in tree["standard_error"].items()}
    return tree | {"standard_error": errors}


def radial_fit(places: F64, moves: F64, half_diagonal: float) -> tuple[F64, F64, F64]:
    """Fit shift x, shift y, scale − 1, k1 and k2 to displacements (n, 2) of marks, by least squares.

    Returned: these five, the residuals (n, 2), and the covariance (5, 5) by these, infinite if undetermined.
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
    # Marks that all lie near the axis do not determine the powers, which stay 0.
    stated = sizes > _UNTOLD * sizes[0]
    inverse = np.where(stated, 1.0 / np.where(stated, sizes, 1.0), 0.0)
    solved = np.einsum("ji,j,nj,n->i", ways, inverse, u, move, optimize=True)
    left = move - np.einsum("ni,i->n", system, solved)
    freedom = max(move.size - int(np.count_nonzero(stated)), 1)
    covariance = float(left @ left) / freedom * np.einsum("ji,j,jk->ik", ways, inverse**2, ways)
    untold = np.abs(ways[~stated]).max(axis=0, initial=0.0) > _UNTOLD
    covariance[np.ix_(untold, untold)] = math.inf
    return solved, left.reshape(2, -1).T, covariance
