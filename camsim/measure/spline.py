"""The edge-spread function as one linear model, fitted to photosites where they lie; kernels on arrays only.

Across the edge (d, pixels) the model is

    ESF(d) = Σ_k c_k·B_k(d)          cubic B-splines of spacing h on −D … D, constant beyond
           + tail·atan(d)             line spread 1/(1 + d²): diffraction's 1/d² beyond D
           + across·level(d)·d        shading: the light changes in proportion to d, more so on the bright side …
           + along·level(d)·s         … and to the place s along the edge
           − ESF′(d)·(turn·s + bend·s²)   what a small error of the edge's direction and curvature does

The last line makes the fit one of Gauss and Newton: its coefficients move the edge, and vanish when it is right.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from camsim.arrays import F64
from camsim.kernels import kernel

TAIL, ACROSS, ALONG, TURN, BEND = range(5)
EXTRAS = 5
_NONZERO = 4 + EXTRAS

_ERF_OF_RISE = 1.8123876
"""2·erf⁻¹(0.8): an error function that rises from 10 to 90 % over 1."""


class Model(NamedTuple):
    """What the kernels need to know of the model; lengths in pixels, signals in units of the step.

    half_width : D;  spacing: h;  columns: number of spline coefficients
    dark       : signal of the dark side, for what shading changes
    scale      : length that ``across``, ``turn`` and ``bend`` are counted in
    rise       : of the edge, 10 to 90 %, for the level of the light between its sides
    slope      : (columns + EXTRAS,) coefficients of the last fit, whose derivative multiplies turn and bend
    """

    half_width: float
    spacing: float
    columns: int
    dark: float
    scale: float
    rise: float

    @classmethod
    def of(cls, *, half_width: float, spacing: float, dark: float, scale: float, rise: float) -> Model:
        """Return a model whose knots lie symmetrically about the edge."""
        intervals = 2 * max(3, math.ceil(half_width / spacing))
        columns = intervals - 1
        return cls(0.5 * intervals * spacing, spacing, columns, dark, scale, rise)


@kernel(forceinline=True)
def _cubic(t: float) -> tuple[float, float, float, float]:
    u = 1.0 - t
    return (
        u * u * u / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
        t * t * t / 6.0,
    )


@kernel()
def _row(d: float, s: float, slope: float, model: Model, index: np.ndarray, value: np.ndarray) -> int:
    """Fill in the non-zero entries of one photosite's row; return how many."""
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
            # The three outermost splines of either end are one column: constant beyond, twice differentiable.
            column = min(max(i + k - 2, 0), n - 1)
            if count and index[count - 1] == column:
                value[count - 1] += b[k]
            else:
                index[count], value[count] = column, b[k]
                count += 1
    turn = math.atan(d)
    level = model.dark + 0.5 + 0.5 * math.erf(_ERF_OF_RISE * d / model.rise)
    along = s / model.scale
    for k, entry in enumerate((turn, level * d / model.scale, level * along, -slope * along, -slope * along * along)):
        index[count + k], value[count + k] = n + k, entry
    return count + EXTRAS


@kernel(allocates=True)
def normal_equations(d: F64, s: F64, slope: F64, v: F64, model: Model) -> tuple[F64, F64]:
    """Return the sums of row·rowᵀ and of row·v over photosites (flat arrays; slope: ESF′ at each)."""
    size = model.columns + EXTRAS
    matrix, right = np.zeros((size, size)), np.zeros(size)
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(d.size):
        count = _row(d[j], s[j], slope[j], model, index, value)
        for a in range(count):
            ia, va = index[a], value[a]
            right[ia] += va * v[j]
            for b in range(a, count):
                matrix[ia, index[b]] += va * value[b]
    for a in range(size):
        for b in range(a):
            matrix[a, b] = matrix[b, a]
    return matrix, right


@kernel(allocates=True)
def residuals(d: F64, s: F64, slope: F64, v: F64, model: Model, coefficients: F64) -> F64:
    """Return v minus the fit at every photosite."""
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    out = np.empty(d.size)
    for j in range(d.size):
        count = _row(d[j], s[j], slope[j], model, index, value)
        fit = 0.0
        for a in range(count):
            fit += value[a] * coefficients[index[a]]
        out[j] = v[j] - fit
    return out


@kernel(allocates=True)
def leverages(d: F64, s: F64, slope: F64, model: Model, inverse: F64) -> F64:
    """Return row·inverse·rowᵀ of every photosite: by how much it pulls the fit towards itself."""
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    out = np.empty(d.size)
    for j in range(d.size):
        count = _row(d[j], s[j], slope[j], model, index, value)
        leverage = 0.0
        for a in range(count):
            for b in range(count):
                leverage += value[a] * inverse[index[a], index[b]] * value[b]
        out[j] = leverage
    return out


@kernel(allocates=True)
def scatter(d: F64, s: F64, slope: F64, variance: F64, model: Model) -> F64:
    """Return the sum of variance·row·rowᵀ: what the photosites' scatter does to the right-hand side."""
    size = model.columns + EXTRAS
    matrix = np.zeros((size, size))
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(d.size):
        count = _row(d[j], s[j], slope[j], model, index, value)
        for a in range(count):
            ia, va = index[a], value[a] * variance[j]
            for b in range(a, count):
                matrix[ia, index[b]] += va * value[b]
    for a in range(size):
        for b in range(a):
            matrix[a, b] = matrix[b, a]
    return matrix


@kernel(allocates=True)
def group_sums(d: F64, s: F64, slope: F64, weight: F64, group: np.ndarray, groups: int, model: Model) -> F64:
    """Return the sum of weight·row over the photosites of each group, (n, groups)."""
    out = np.zeros((model.columns + EXTRAS, groups))
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    for j in range(d.size):
        count = _row(d[j], s[j], slope[j], model, index, value)
        for a in range(count):
            out[index[a], group[j]] += weight[j] * value[a]
    return out


@kernel(allocates=True)
def _rows(d: F64, model: Model) -> F64:
    index, value = np.empty(_NONZERO, np.int64), np.empty(_NONZERO)
    rows = np.zeros((d.size, model.columns + EXTRAS))
    for j in range(d.size):
        count = _row(d[j], 0.0, 0.0, model, index, value)
        for a in range(count):
            rows[j, index[a]] = value[a]
    return rows


@kernel(allocates=True)
def slopes(d: F64, model: Model, coefficients: F64) -> F64:
    """Return the derivative of the spread function at every photosite."""
    n, h = model.columns, model.spacing
    out = np.empty(d.size)
    for j in range(d.size):
        total = coefficients[n + TAIL] / (1.0 + d[j] * d[j])
        u = (d[j] + model.half_width) / h
        if 0.0 <= u < n + 1:
            i = int(u)
            t = u - i
            w = 1.0 - t
            rates = (-0.5 * w * w, 1.5 * t * t - 2.0 * t, -1.5 * w * w + 2.0 * w, 0.5 * t * t)
            for k in range(4):
                total += rates[k] * coefficients[min(max(i + k - 2, 0), n - 1)] / h
        out[j] = total
    return out


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
    rows[:, n + TAIL] = 1.0 / (1.0 + d * d)
    return rows


def transform_rows(frequency: F64, model: Model, reach: tuple[float, float] | None) -> np.ndarray:
    """Return (m, n) complex rows that give the line spread's Fourier transform.

    frequency : (m,) cycles/pixel
    reach     : how far the integral goes on the dark and the bright side; None for all the way, tail included

    In closed form: a cubic B-spline's transform is h·sinc⁴(f·h), differentiation is 2πi·f, and the constant ends are
    geometric sums. Nothing is left to correct for a numerical derivative or a bin's width.
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
        rows[:, n + TAIL] = np.pi * np.exp(-np.abs(omega[:, 0]))
    else:
        low, high = -math.atan(reach[0]), math.atan(reach[1])
        # d = tan(a) makes the integrand a pure phase.
        panels = max(8, math.ceil((reach[0] + reach[1]) * max(float(frequency.max()), 0.1)))
        x, w = np.polynomial.legendre.leggauss(16)
        d_cuts = np.linspace(-reach[0], reach[1], panels + 1)
        cuts = np.union1d(np.arctan(d_cuts), np.linspace(low, high, 9))
        half = 0.5 * np.diff(cuts)
        angle = (0.5 * (cuts[:-1] + cuts[1:])[:, None] + half[:, None] * x).ravel()
        rows[:, n + TAIL] = np.exp(-1j * omega * np.tan(angle)) @ (half[:, None] * w).ravel()
    return rows
