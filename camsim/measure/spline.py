"""The edge-spread function as one linear model, fitted to photosites at their positions; kernels on arrays only.

Across the edge (d, pixels) the model is

    ESF(d) = Σ_k c_k·B_k(d)          cubic B-splines of spacing h on −D … D, constant beyond
           + tail·tail_spread(d)      line spread 1/d²: diffraction's beyond D
           + level(d)·(across·d + along·s)   shading: the light changes in proportion to the level, ESF itself
           + Σ_jk stray_jk·d^j·s^k   light from other edges: smooth, and equal on bright and dark
           − ESF′(d)·(turn·s + bend·s²)   effect of a small error of the edge's direction and curvature

Level and ESF′ are those of the previous fit: the last line makes this a Gauss–Newton iteration, whose coefficients
move the edge and vanish at convergence; the fitted level makes shading a product.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.core.arrays import F64, distinct
from camsim.core.kernels import kernel

TAIL, ACROSS, ALONG, TURN, BEND, STRAY = range(6)
STRAY_POWERS = ((1, 0), (2, 0), (0, 1), (0, 2), (1, 1))
"""Powers of d and s in light from other edges; a constant is included in the two levels."""

EXTRAS = STRAY + len(STRAY_POWERS)
_NONZERO = 4 + EXTRAS

FAR, FAR_ELSE = -1.0 / 2.0, -1.0 / 3.0
"""B of the tail's line spread, (1 − B)/(1 + d²) + B/(4 + d²) or 1/d² + c/d⁴ + …: c = ½, and 0.

For diffraction's 1/d², photosites of one pitch make c = ¼; an OLPF may add as much or more.
"""


class Model(NamedTuple):
    """Parameters of the model for the kernels; lengths in pixels, signals in units of the step.

    half_width : D;  spacing: h;  columns: number of spline coefficients
    scale      : unit of length of ``across``, ``turn``, ``bend`` and ``stray``
    far        : B of the tail
    tail       : whether the tail and the shading across the edge are fitted;  stray: whether light from other edges is
    """

    half_width: float
    spacing: float
    columns: int
    scale: float
    far: float = FAR
    tail: bool = True
    stray: bool = True

    @classmethod
    def of(cls, *, half_width: float, spacing: float, scale: float) -> Model:
        """Return a model with knots symmetric about the edge."""
        intervals = 2 * max(3, math.ceil(half_width / spacing))
        return cls(0.5 * intervals * spacing, spacing, intervals - 1, scale)

    @property
    def tail_end(self) -> float:
        """The tail's spread function far on the bright side."""
        return 0.5 * math.pi * (1.0 - 0.5 * self.far)


class Placed(NamedTuple):
    """Photosites near an edge, flat arrays: distance d, position along it s, slope and level of the ESF there."""

    d: F64
    s: F64
    slope: F64
    level: F64

    def only(self, which: np.ndarray) -> Placed:
        """Return the selected photosites."""
        return Placed(*(part[which] for part in self))

    def straight(self) -> Placed:
        """Return the photosites with slope 0, for a fit that holds the line fixed."""
        return self._replace(slope=np.zeros(self.d.size))


class Shape(NamedTuple):
    """The fitted spread function; ``dark`` is the origin of its signals, above black."""

    model: Model
    coefficients: F64
    dark: float

    def placed(self, d: F64, s: F64) -> Placed:
        """Return photosites at distances and positions, each with this function's slope and level."""
        level, slope = _levels_and_slopes(d, self.model, self.coefficients)
        return Placed(d, s, slope, self.dark + level)


@kernel(forceinline=True)
def _cubic(t: float) -> tuple[float, float, float, float]:
    u = 1.0 - t
    return (
        u * u * u / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
        t * t * t / 6.0,
    )


@kernel(forceinline=True)
def _tail_spread(d: float, far: float) -> float:
    return (1.0 - far) * math.atan(d) + 0.5 * far * math.atan(0.5 * d)


@kernel()
def _row(d: float, s: float, slope: float, level: float, model: Model, index: np.ndarray, value: np.ndarray) -> int:
    """Fill in the entries of one photosite's row that are not zero; return how many."""
    n = model.columns
    u = (d + model.half_width) / model.spacing
    count = 0
    if u <= 0.0:
        index[0], value[0], count = 0, 1.0, 1
    elif u >= n + 1:
        index[0], value[0], count = n - 1, 1.0, 1
    else:
        i = int(u)
        b = _cubic(u - i)
        for k in range(4):
            # The three outermost splines at either end share one column: constant beyond, twice differentiable.
            column = min(max(i + k - 2, 0), n - 1)
            if count and index[count - 1] == column:
                value[count - 1] += b[k]
            else:
                index[count], value[count] = column, b[k]
                count += 1
    across, along = d / model.scale, s / model.scale
    if model.tail:
        index[count], value[count] = n + TAIL, _tail_spread(d, model.far)
        index[count + 1], value[count + 1] = n + ACROSS, level * across
        count += 2
    index[count], value[count] = n + ALONG, level * along
    count += 1
    if slope != 0.0:
        index[count], value[count] = n + TURN, -slope * along
        index[count + 1], value[count + 1] = n + BEND, -slope * along * along
        count += 2
    if model.stray:
        for k, entry in enumerate((across, across * across, along, along * along, across * along)):
            index[count + k], value[count + k] = n + STRAY + k, entry
        count += len(STRAY_POWERS)
    return count


@kernel(allocates=True)
def normal_equations(rows: Placed, v: F64, model: Model) -> tuple[F64, F64]:
    """Return the sums of row·rowᵀ and of row·v over photosites."""
    size = model.columns + EXTRAS
    matrix, right = np.zeros((size, size)), np.zeros(size)
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(rows.d.size):
        count = _row(rows.d[j], rows.s[j], rows.slope[j], rows.level[j], model, index, value)
        for a in range(count):
            ia, va = index[a], value[a]
            right[ia] += va * v[j]
            for b in range(a, count):
                matrix[ia, index[b]] += va * value[b]
    for a in range(size):
        for b in range(a):
            matrix[a, b] = matrix[b, a]
    return matrix, right


@kernel()
def factor(matrix: F64) -> bool:
    """Replace a symmetric matrix UᵀU by its Cholesky factor U; nothing below the diagonal is read or written.

    False if the matrix is not positive definite. To import LAPACK from SciPy would take as long as a thousand fits.
    """
    for k in range(len(matrix)):
        if not matrix[k, k] > 0.0:
            return False
        root = math.sqrt(matrix[k, k])
        for j in range(k, len(matrix)):
            matrix[k, j] /= root
        for i in range(k + 1, len(matrix)):
            for j in range(i, len(matrix)):
                matrix[i, j] -= matrix[k, i] * matrix[k, j]
    return True


@kernel()
def substitute(upper: F64, right: F64) -> None:
    """Replace right-hand sides (n, m) by solutions of the system that ``factor`` factored."""
    for k in range(len(upper)):
        for j in range(right.shape[1]):
            right[k, j] /= upper[k, k]
        for i in range(k + 1, len(upper)):
            for j in range(right.shape[1]):
                right[i, j] -= upper[k, i] * right[k, j]
    for k in range(len(upper) - 1, -1, -1):
        for i in range(k + 1, len(upper)):
            for j in range(right.shape[1]):
                right[k, j] -= upper[k, i] * right[i, j]
        for j in range(right.shape[1]):
            right[k, j] /= upper[k, k]


@kernel(allocates=True)
def residuals(rows: Placed, v: F64, model: Model, coefficients: F64) -> F64:
    """Return v minus the fit at every photosite."""
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    out = np.empty(rows.d.size)
    for j in range(rows.d.size):
        count = _row(rows.d[j], rows.s[j], rows.slope[j], rows.level[j], model, index, value)
        fit = 0.0
        for a in range(count):
            fit += value[a] * coefficients[index[a]]
        out[j] = v[j] - fit
    return out


@kernel(allocates=True)
def leverages(rows: Placed, model: Model, inverse: F64) -> F64:
    """Return the leverage row·inverse·rowᵀ of every photosite."""
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    out = np.empty(rows.d.size)
    for j in range(rows.d.size):
        count = _row(rows.d[j], rows.s[j], rows.slope[j], rows.level[j], model, index, value)
        leverage = 0.0
        for a in range(count):
            for b in range(count):
                leverage += value[a] * inverse[index[a], index[b]] * value[b]
        out[j] = leverage
    return out


@kernel(allocates=True)
def scatter(rows: Placed, variance: F64, model: Model) -> F64:
    """Return the sum of variance·row·rowᵀ: the covariance of the right-hand side."""
    size = model.columns + EXTRAS
    matrix = np.zeros((size, size))
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(rows.d.size):
        count = _row(rows.d[j], rows.s[j], rows.slope[j], rows.level[j], model, index, value)
        for a in range(count):
            ia, va = index[a], value[a] * variance[j]
            for b in range(a, count):
                matrix[ia, index[b]] += va * value[b]
    for a in range(size):
        for b in range(a):
            matrix[a, b] = matrix[b, a]
    return matrix


@kernel(allocates=True)
def group_sums(rows: Placed, weight: F64, group: np.ndarray, groups: int, model: Model) -> F64:
    """Return the sum of weight·row over the photosites of each group, (n, groups)."""
    out = np.zeros((model.columns + EXTRAS, groups))
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(rows.d.size):
        count = _row(rows.d[j], rows.s[j], rows.slope[j], rows.level[j], model, index, value)
        for a in range(count):
            out[index[a], group[j]] += weight[j] * value[a]
    return out


@kernel(allocates=True)
def _rows(d: F64, model: Model) -> F64:
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    rows = np.zeros((d.size, model.columns + EXTRAS))
    for j in range(d.size):
        count = _row(d[j], 0.0, 0.0, 0.0, model, index, value)
        for a in range(count):
            rows[j, index[a]] = value[a]
    return rows


@kernel(allocates=True)
def _levels_and_slopes(d: F64, model: Model, coefficients: F64) -> tuple[F64, F64]:
    """Return the spread function and its derivative at every photosite, without shading."""
    n, h = model.columns, model.spacing
    levels, slopes = np.empty(d.size), np.empty(d.size)
    for j in range(d.size):
        level = coefficients[n + TAIL] * _tail_spread(d[j], model.far)
        slope = coefficients[n + TAIL] * ((1.0 - model.far) / (1.0 + d[j] * d[j]) + model.far / (4.0 + d[j] * d[j]))
        u = (d[j] + model.half_width) / h
        if u <= 0.0:
            level += coefficients[0]
        elif u >= n + 1:
            level += coefficients[n - 1]
        else:
            i = int(u)
            t = u - i
            w = 1.0 - t
            values = _cubic(t)
            rates = (-0.5 * w * w, 1.5 * t * t - 2.0 * t, -1.5 * w * w + 2.0 * w, 0.5 * t * t)
            for k in range(4):
                coefficient = coefficients[min(max(i + k - 2, 0), n - 1)]
                level += values[k] * coefficient
                slope += rates[k] * coefficient / h
        levels[j], slopes[j] = level, slope
    return levels, slopes


def spread_rows(d: F64, model: Model) -> F64:
    """Return (m, n) rows that give the ESF at distances d, without shading."""
    rows = _rows(np.ascontiguousarray(d, np.float64), model)
    rows[:, model.columns + ACROSS :] = 0.0
    return rows


def line_rows(d: F64, model: Model) -> F64:
    """Return (m, n) rows that give the line spread at distances d: the derivative, exactly."""
    n, h = model.columns, model.spacing
    rows = np.zeros((d.size, n + EXTRAS))
    u = (d + model.half_width) / h
    inside = (u >= 0.0) & (u < n + 1)
    i = np.floor(u[inside]).astype(np.int64)
    t = u[inside] - i
    where = np.flatnonzero(inside)
    for k, weight in enumerate(
        (-0.5 * (1 - t) ** 2, 1.5 * t**2 - 2 * t, -1.5 * (1 - t) ** 2 + 2 * (1 - t), 0.5 * t**2)
    ):
        np.add.at(rows, (where, np.clip(i + k - 2, 0, n - 1)), weight / h)
    rows[:, n + TAIL] = (1.0 - model.far) / (1.0 + d * d) + model.far / (4.0 + d * d)
    return rows


def transform_rows(frequency: F64, model: Model, reach: tuple[float, float] | None) -> np.ndarray:
    """Return (m, n) complex rows that give the line spread's Fourier transform.

    frequency : (m,) cycles/pixel
    reach     : limits of the integral on the dark and the bright side; None: infinite, with the tail

    In closed form: a cubic B-spline's transform is h·sinc⁴(f·h), differentiation is 2πi·f, and the constant ends are
    geometric sums. No correction for a numerical derivative or a bin width is needed.
    """
    n, h = model.columns, model.spacing
    omega = 2.0 * np.pi * frequency[:, None]
    centre = -model.half_width + (np.arange(n) + 1.0) * h
    rows = np.zeros((frequency.size, n + EXTRAS), complex)
    bell = np.sinc(frequency[:, None] * h) ** 4
    phase = np.exp(-1j * omega * centre)
    rows[:, :n] = 1j * omega * h * bell * phase
    zero = frequency == 0.0
    turn = 1j * omega[:, 0] * h
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (turn / (1.0 - np.exp(turn)), turn / (1.0 - np.exp(-turn)))
    for column, end, limit in ((0, ends[0], -1.0), (n - 1, ends[1], 1.0)):
        rows[:, column] = np.where(zero, limit, end * bell[:, 0] * phase[:, column])
    if reach is None:
        fall = np.exp(-np.abs(omega[:, 0]))
        rows[:, n + TAIL] = np.pi * ((1.0 - model.far) * fall + 0.5 * model.far * fall**2)
    else:
        low, high = -math.atan(reach[0]), math.atan(reach[1])
        # d = tan(a) makes the integrand a pure phase.
        panels = max(8, math.ceil((reach[0] + reach[1]) * max(float(frequency.max()), 0.1)))
        x, w = np.polynomial.legendre.leggauss(16)
        d_cuts = np.linspace(-reach[0], reach[1], panels + 1)
        cuts = distinct(np.concatenate([np.arctan(d_cuts), np.linspace(low, high, 9)]))
        half = 0.5 * np.diff(cuts)
        angle = (0.5 * (cuts[:-1] + cuts[1:])[:, None] + half[:, None] * x).ravel()
        d = np.tan(angle)
        rows[:, n + TAIL] = np.exp(-1j * omega * d) @ (
            (half[:, None] * w).ravel() * (1.0 - model.far + model.far * (1.0 + d * d) / (4.0 + d * d))
        )
    return rows
