"""Distribution of a photosite's temporal noise: normal or heavy-tailed, uniform or not, with telegraph noise or not.

Differences of pairs of equal darks are free of fixed patterns, while properties of a photosite (its noise level, its
telegraph noise) affect all of its pairs. So joint counts of |difference| of two pairs separate the two: heavy tails
leave the pairs independent, non-uniform noise makes them large together. The parameters maximise the likelihood of
these counts (a composite likelihood; errors follow from the sandwich formula, with the scatter over blocks of rows).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np
import scipy.interpolate
import scipy.optimize
import scipy.special

from camsim.core.arrays import F64, I64
from camsim.measure.calibrate.tail_counts import PairCounts, SingleCounts
from camsim.measure.noise.estimate import SURE, Estimate, no_figure
from camsim.sensor.stages.read_noise import tukey_quantiles, tukey_sigma

Law: TypeAlias = Literal["normal", "student", "tukey"]

LEAST_FRAMES = 4
"""Frames for two pairs of a photosite."""
_SPREADS = 9

_DECAYED = 30.0
_AT = _DECAYED * np.linspace(0.0, 1.0, 500) ** 1.5
_TUKEY = -0.456, 0.206
_NONE = 1e-30
_ROUNDED = 1e-19


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """A noise distribution in data numbers; components with a figure of 0 are absent.

    sigma_dn     : standard deviation of its normal or heavy-tailed component
    tails        : 1/degrees of freedom of Student's t, or λ of Tukey's distribution
    spread       : standard deviation of the logarithm of each photosite's standard deviation
    fraction, amplitude_dn : share of photosites with telegraph noise, and its mean amplitude
    """

    law: Law
    sigma_dn: float
    tails: float = 0.0
    spread: float = 0.0
    fraction: float = 0.0
    amplitude_dn: float = 0.0

    @property
    def telegraph_dn2(self) -> float:
        """The mean variance of telegraph noise over photosites."""
        return 0.5 * self.fraction * self.amplitude_dn**2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Fitted:
    """The selected distribution.

    errors : standard errors of the shape's figures by name
    rises  : increase of the log-likelihood by each component, in its standard errors, in order of selection; for the
             first rejected one, name and number
    """

    shape: Shape
    errors: dict[str, float]
    telegraph_sigma_dn2: float
    rises: tuple[tuple[str, float], ...]
    refused: tuple[str, float]


def fit_tails(
    frames: Sequence[I64],
    *,
    step_dn: float,
    normal_dn2: float,
    normal_sigma_dn2: float = 0.0,
    fixed_dn2: float = 0.0,
    period: tuple[int, int] = (1, 1),
) -> Fitted:
    """Return the noise distribution of equal darks, (rows, cols) codes.

    step_dn    : between codes
    normal_dn2 : variance of further normal noise in them (after the gain, of rows), and its error
    fixed_dn2  : variance of the fixed pattern, normal over photosites;  period: of the filter array, whose cells may
                 have separate black levels

    A component (tails, telegraph noise, non-uniformity) is selected if the log-likelihood increases by more than 4
    standard errors of the increase, estimated from blocks of rows (Vuong's test), in order of increase. Differences are
    smoother than the codes: the choice between Student's and Tukey's distribution also uses single codes.
    """
    seen = PairCounts.of(frames, step_dn)
    model = _Model(seen, normal_dn2)
    start = math.sqrt(max(seen.variance_dn2 - normal_dn2, 0.05 * seen.variance_dn2))
    best = model.best(Shape(law="normal", sigma_dn=start))
    rises: list[tuple[str, float]] = []
    while True:
        tried = [(name, model.best(more)) for name, more in _with_more(best[0])]
        if not tried:
            refused = ("", 0.0)
            break
        name, found = max(tried, key=lambda each: each[1][1].sum())
        rise = _rise(found[1] - best[1])
        if rise < SURE:
            refused = (name, rise)
            break
        rises.append((name, rise))
        best = found
    if best[0].law != "normal":
        other: Law = "tukey" if best[0].law == "student" else "student"
        swapped = model.best(replace(best[0], law=other, tails=_FIRST_TAILS[other]))
        singles = SingleCounts.of(frames, step_dn, period)
        either = [each[1].sum() + model.logarithm_of(singles, each[0], fixed_dn2) for each in (best, swapped)]
        if either[1] > either[0]:
            best = swapped
    errors, telegraph = model.errors(best[0], normal_sigma_dn2)
    return Fitted(shape=best[0], errors=errors, telegraph_sigma_dn2=telegraph, rises=tuple(rises), refused=refused)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AtGain:
    """Darks of a setting: codes, gain (DN/e⁻), and the variances of photosites (without rounding) and of rows, DN²."""

    frames: Sequence[I64]
    gain_dn_per_e: float
    each_dn2: float
    rows_dn2: float


def fit_after(darks: Sequence[AtGain], law: Fitted, law_gain_dn_per_e: float, *, step_dn: float) -> Estimate:
    """Return the variance of normal noise after the gain, DN², from how far each setting's darks still are from normal.

    The distribution before the gain is known from one setting; the total variance of each setting is fixed.
    """
    models = [_Model(PairCounts.of(each.frames, step_dn), 0.0) for each in darks]

    def logarithms(after_dn2: float, shape: Shape) -> F64:
        total: Any = 0.0
        for model, each in zip(models, darks, strict=True):
            by = each.gain_dn_per_e / law_gain_dn_per_e
            here = replace(shape, amplitude_dn=shape.amplitude_dn * by)
            one = max(each.each_dn2 - after_dn2 - here.telegraph_dn2, 1e-4 * each.each_dn2)
            model.normal_dn2 = after_dn2 + each.rows_dn2
            total = total + model.logarithms(replace(here, sigma_dn=math.sqrt(one)))
        found: F64 = total
        return found

    most = min(each.each_dn2 for each in darks)

    def best(shape: Shape) -> float:
        found = scipy.optimize.minimize_scalar(
            lambda after: -float(logarithms(after, shape).sum()), bounds=(0.0, most), method="bounded",
            options={"xatol": 1e-4 * most},
        )  # fmt: skip
        return float(found.x)

    value, width = best(law.shape), 0.01 * most
    if not 2.0 * width < value < most - 2.0 * width:
        return no_figure("the darks' law tells nothing of the noise after the gain")
    less, here, more = (logarithms(value + by, law.shape) for by in (-width, 0.0, width))
    scores, curvature = (more - less) / (2.0 * width), float((more - 2.0 * here + less).sum()) / width**2
    if not curvature < 0.0:
        return no_figure("the darks' law tells nothing of the noise after the gain")
    one = math.sqrt(scores.size) * float(np.std(scores, ddof=1)) / -curvature
    moved = [
        max(
            abs(best(replace(law.shape, **{name: getattr(law.shape, name) + by * law.errors[name]})) - value)
            for by in (-1.0, 1.0)
        )
        for name in ("tails", "spread", "fraction", "amplitude_dn")
        if getattr(law.shape, name)
    ]
    return Estimate(value, math.hypot(one, *moved))


_FIRST_TAILS: dict[Law, float] = {"normal": 0.0, "student": 0.12, "tukey": -0.05}


def _with_more(shape: Shape) -> list[tuple[str, Shape]]:
    """Return the distributions with one further component."""
    more: list[tuple[str, Shape]] = []
    if shape.law == "normal":
        laws: tuple[Law, ...] = ("student", "tukey")
        more += [(law, replace(shape, law=law, tails=_FIRST_TAILS[law])) for law in laws]
    if not shape.fraction:
        more.append(("telegraph", replace(shape, fraction=0.01, amplitude_dn=4.0 * shape.sigma_dn)))
    if not shape.spread:
        more.append(("spread", replace(shape, spread=0.15)))
    return more


def _rise(by_block: F64) -> float:
    scatter = float(np.std(by_block, ddof=1)) * math.sqrt(len(by_block))
    return float(by_block.sum()) / max(scatter, 1e-9)


def _heard(wave: F64) -> int:
    """Return how many of a wave's frequencies to sum: beyond them it is less than a probability's rounding."""
    return int(np.flatnonzero(wave > _ROUNDED)[-1]) + 1


class _Model:
    """Probabilities of the bins under a distribution, from its characteristic function."""

    def __init__(self, seen: PairCounts, normal_dn2: float) -> None:
        self.seen, self.normal_dn2 = seen, normal_dn2
        top = int(seen.lattice[-1])
        # Codes are a lattice, so frequencies up to one cycle per step and their aliases suffice; the period is wide
        # enough that differences beyond the greatest one do not wrap around.
        period = 2 * (top + 8)
        self.repeats = max(2, math.ceil(6.0 * seen.step_dn / math.sqrt(seen.variance_dn2)) + 1)
        self.omega = 2.0 * math.pi * np.arange(self.repeats * period // 2 + 1) / (period * seen.step_dn)
        weight = np.full(self.omega.size, 2.0 / period)
        weight[0] = 1.0 / period
        phases = np.cos(np.outer(np.arange(top + 1), self.omega * seen.step_dn)) * weight
        phases[1:] *= 2.0
        self.of_bins = np.stack([phases[seen.bin_of == k].sum(axis=0) for k in range(seen.counts.shape[1])])
        self.rounding = np.sinc(self.omega * seen.step_dn / (2.0 * math.pi)) ** 2
        pitch = 0.7 * math.sqrt(seen.variance_dn2)
        count = min(int(1.1 * top * seen.step_dn / pitch) + 2, 400)
        self.amplitudes = (np.arange(count) + 0.5) * pitch
        self.jumps = np.cos(0.5 * np.outer(self.amplitudes, self.omega)) ** 2
        self.pitch = pitch
        nodes, weights = np.polynomial.hermite_e.hermegauss(_SPREADS)
        self.spreads, self.spread_weights = nodes, weights / weights.sum()

    def probabilities(self, shape: Shape) -> F64:
        """Return (bins, bins) probabilities of two pairs."""
        decays = np.exp(-self.normal_dn2 * self.omega**2) * self.rounding
        sigmas, of_sigma = self._sigmas(shape)
        curve = _characteristic(shape.law, shape.tails)
        one = np.stack([curve(self.omega * sigma) ** 2 * decays for sigma in sigmas])
        heard = _heard(one.max(axis=0))
        one, of_bins = one[:, :heard], self.of_bins[:, :heard].T
        still = one @ of_bins
        joint: F64 = (1.0 - shape.fraction) * (still.T * of_sigma) @ still
        if shape.fraction:
            of_jump = self._of_jumps(shape)
            moved = (one[:, None, :] * self.jumps[:, :heard]).reshape(-1, heard) @ of_bins
            joint = joint + shape.fraction * (moved.T * np.outer(of_sigma, of_jump).ravel()) @ moved
        return joint

    def _sigmas(self, shape: Shape) -> tuple[F64, F64]:
        """Return nodes of the photosites' standard deviations, and their weights."""
        if not shape.spread:
            return np.array([shape.sigma_dn]), np.ones(1)
        return shape.sigma_dn * np.exp(shape.spread * self.spreads - shape.spread**2), self.spread_weights

    def _of_jumps(self, shape: Shape) -> F64:
        """Return the share of each of ``amplitudes``."""
        edges = np.append(self.amplitudes - 0.5 * self.pitch, np.inf) / shape.amplitude_dn
        shares: F64 = -np.diff(np.exp(-edges))
        return shares

    def _of_one(self, shape: Shape, omega: F64) -> F64:
        """Return the characteristic function (n,) of one code about its photosite's own mean."""
        sigmas, of_sigma = self._sigmas(shape)
        curve = _characteristic(shape.law, shape.tails)
        wave: F64 = of_sigma @ np.stack([curve(omega * sigma) for sigma in sigmas])
        wave *= np.exp(-0.5 * self.normal_dn2 * omega**2) * np.sinc(omega * self.seen.step_dn / (2.0 * math.pi))
        if shape.fraction:
            jumps = np.cos(0.5 * np.outer(self.amplitudes, omega))
            wave *= 1.0 - shape.fraction + shape.fraction * (self._of_jumps(shape) @ jumps)
        return wave

    def logarithm_of(self, singles: SingleCounts, shape: Shape, fixed_dn2: float) -> float:
        """Return the log-likelihood of all single codes."""
        step_dn = self.seen.step_dn
        period = 2 * len(singles.lattice) + 16
        omega = (2.0 * math.pi / (period * step_dn)) * np.arange(self.repeats * period // 2 + 1, dtype=np.float64)
        wave = self._of_one(shape, omega) * np.exp(-0.5 * fixed_dn2 * omega**2)
        wave *= np.where(omega > 0.0, 2.0, 1.0) / period
        heard = _heard(np.abs(wave))
        omega, wave = omega[:heard], wave[:heard]
        total = 0.0
        for counts, mean in zip(singles.counts, singles.mean.tolist(), strict=True):
            seen = np.flatnonzero(counts)
            share = np.cos(np.outer(singles.lattice[seen] - mean, omega * step_dn)) @ wave
            total += float(counts[seen] @ np.log(np.maximum(share, _NONE)))
        return total

    def logarithms(self, shape: Shape) -> F64:
        """Return the log-likelihood of each block of rows."""
        joint = np.maximum(self.probabilities(shape), _NONE)
        stated: F64 = np.tensordot(self.seen.counts, np.log(joint / joint.sum()), axes=2)
        return stated

    def best(self, start: Shape) -> tuple[Shape, F64]:
        """Return the maximum-likelihood shape with the components of ``start``, and its log-likelihood by block."""
        total = self.seen.counts.sum()

        def worth(values: F64) -> float:
            shape = _shape_of(start, values)
            return math.inf if shape is None else -float(self.logarithms(shape).sum()) / total

        first = _values_of(start)
        simplex = first + np.vstack([np.zeros(first.size), np.diag(np.full(first.size, 0.25))])
        found = scipy.optimize.minimize(
            worth, first, method="Nelder-Mead",
            options={"initial_simplex": simplex, "xatol": 5e-4, "fatol": 2e-9, "maxfev": 500},
        )  # fmt: skip
        shape = _shape_of(start, found.x)
        assert shape is not None
        return shape, self.logarithms(shape)

    def errors(self, shape: Shape, normal_sigma_dn2: float) -> tuple[dict[str, float], float]:
        """Return the standard errors of the shape's figures, and of the variance of the shape's telegraph noise."""
        values = _values_of(shape)
        size = values.size
        width = 0.01

        def at(values: F64, normal_dn2: float | None = None) -> F64:
            moved = _shape_of(shape, values, beyond=0.006)
            assert moved is not None
            original, self.normal_dn2 = self.normal_dn2, self.normal_dn2 if normal_dn2 is None else normal_dn2
            stated = self.logarithms(moved)
            self.normal_dn2 = original
            return stated

        def gradient(values: F64, normal_dn2: float | None = None) -> F64:
            steps = width * np.eye(size)
            return np.stack([
                (at(values + step, normal_dn2) - at(values - step, normal_dn2)) / (2.0 * width) for step in steps
            ], axis=1)  # fmt: skip

        scores = gradient(values)
        hessian = np.stack([
            (gradient(values + step).sum(axis=0) - gradient(values - step).sum(axis=0)) / (2.0 * width)
            for step in width * np.eye(size)
        ])  # fmt: skip
        hessian = 0.5 * (hessian + hessian.T)
        blocks = len(scores)
        scatter = (scores - scores.mean(axis=0)).T @ (scores - scores.mean(axis=0)) * blocks / (blocks - 1)
        inverse = np.linalg.inv(hessian)
        covariance = inverse @ scatter @ inverse
        if normal_sigma_dn2:
            more = self.normal_dn2 + normal_sigma_dn2
            less = max(self.normal_dn2 - normal_sigma_dn2, 0.0)
            pull = (gradient(values, more) - gradient(values, less)).sum(axis=0) / (more - less)
            moved = inverse @ pull * normal_sigma_dn2
            covariance = covariance + np.outer(moved, moved)
        return _errors_of(shape, values, covariance)


def _errors_of(shape: Shape, values: F64, covariance: F64) -> tuple[dict[str, float], float]:
    def slope(figure: Callable[[Shape], float]) -> F64:
        width = 1e-4
        found = []
        for step in width * np.eye(values.size):
            more, less = _shape_of(shape, values + step), _shape_of(shape, values - step)
            found.append(0.0 if more is None or less is None else (figure(more) - figure(less)) / (2.0 * width))
        return np.array(found)

    def error(figure: Callable[[Shape], float]) -> float:
        along = slope(figure)
        return math.sqrt(max(float(along @ covariance @ along), 0.0))

    names = ("sigma_dn", "tails", "spread", "fraction", "amplitude_dn")
    stated = {name: error(lambda each, name=name: float(getattr(each, name))) for name in names}  # type: ignore[misc]
    return stated, error(lambda each: each.telegraph_dn2)


def _values_of(shape: Shape) -> F64:
    values = [math.log(shape.sigma_dn)]
    if shape.law != "normal":
        values.append(4.0 * shape.tails)
    if shape.spread:
        values.append(math.log(shape.spread))
    if shape.fraction:
        values += [math.log(shape.fraction / (1.0 - shape.fraction)), math.log(shape.amplitude_dn)]
    return np.array(values)


def _shape_of(like: Shape, values: F64, beyond: float = 0.0) -> Shape | None:
    """Return the shape of these values with the components of another; None beyond the limits by more than that."""
    left = iter(values.tolist())
    changed: dict[str, Any] = {"sigma_dn": math.exp(next(left))}
    if like.law != "normal":
        tails = 0.25 * next(left)
        least, most = (0.01, 0.49) if like.law == "student" else (-0.45, 0.2)
        if not least - beyond < tails < most + beyond:
            return None
        changed["tails"] = tails
    if like.spread:
        changed["spread"] = math.exp(next(left))
        if changed["spread"] > 2.0 + 10.0 * beyond:
            return None
    if like.fraction:
        changed["fraction"] = 1.0 / (1.0 + math.exp(-next(left)))
        changed["amplitude_dn"] = math.exp(next(left))
    return replace(like, **changed)


def _characteristic(law: Law, tails: float) -> Callable[[F64], F64]:
    """Return the characteristic function of a distribution of standard deviation 1, at frequencies of 0 or more."""
    if law == "normal":
        return lambda u: np.exp(-0.5 * u * u)
    if law == "student":
        dof = 1.0 / tails
        scaled = np.maximum(math.sqrt(dof - 2.0) * _AT, 1e-9)
        half = 0.5 * dof
        stated = np.exp(
            np.log(scipy.special.kve(half, scaled)) - scaled + half * np.log(scaled)
            - scipy.special.gammaln(half) - (half - 1.0) * math.log(2.0)
        )  # fmt: skip
        stated[0] = 1.0
    else:
        stated = _tukey_waves()(math.sqrt(0.5 + tails))
    spline = scipy.interpolate.CubicSpline(_AT, stated)

    def curve(u: F64) -> F64:
        found: F64 = np.where(u < _DECAYED, spline(np.minimum(u, _DECAYED)), 0.0)
        return found

    return curve


@functools.cache
def _tukey_waves() -> scipy.interpolate.BarycentricInterpolator:
    """Return Tukey's characteristic function of standard deviation 1 at ``_AT``, as a polynomial in √(λ + ½).

    A fit asks for two thousand of them, and the integrals of one take a hundred times longer than the polynomial.
    """
    place = np.linspace(0.0, 40.0, 3601)
    rest = 1.0 / (1.0 + np.exp(place))  # 1 − p
    weight = 2.0 * rest * (1.0 - rest) * (place[1] - place[0])
    weight[0] *= 0.5
    least, most = np.sqrt(0.5 + np.array(_TUKEY))
    nodes = 0.5 * (least + most + (most - least) * np.cos(math.pi * (np.arange(24) + 0.5) / 24))
    far = (-tukey_quantiles(rest, one) / tukey_sigma(one) for one in (nodes**2 - 0.5).tolist())
    return scipy.interpolate.BarycentricInterpolator(nodes, [np.cos(np.outer(_AT, each)) @ weight for each in far])
