"""Samples of the check's transfers at one place of the frame, and how many of them follow it."""

from __future__ import annotations

import functools
import math

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kernels import shared
from camsim.optics.placed import PlacedLens
from camsim.optics.pupil import Pupil
from camsim.optics.rim import rim_of
from camsim.optics.zernike import orders, zernike
from camsim.products import product
from camsim.quadrature import chebyshev, gauss_legendre
from camsim.rendering.across.judge_kernels import add_nodes

FEWEST_NODES = (14, 28, 20, 16)  # of the overlap's rule, shifts, half a circle of angles, wavelengths
PER_WAVE = (1.1, 1.7, 1.6, 2.2)  # of the steepest slope, waves per radius: nodes more to begin with, at 1e-5
COARSEST = 0.7  # of them, at 2e-3 and more
EACH = 0.02  # of the tolerance: what a transfer may lose by the rule, and by each of the others' last terms
FINEST = 5e-11  # of a transfer: sums of cosines that are known to 2e-11
MORE, LAST = 1.25, 5  # times as many nodes where it loses more; terms that are looked at: some are 0
LOUD = 100.0  # times what is allowed: past that, by as much again
SOME, ROUND = 8, 25  # shifts, and angles on a quarter of a circle, at which rules are compared
FEWER = 6  # of these angles every so many-th, at many wavelengths
SPARED = 0.5  # of a rule's nodes, from which the search begins at each of these shifts
AXIS = 1e-14  # from the line through both copies' middles: is on it
ROUNDS = 12  # of that, fifteen times as many: what is not quiet then is what sums leave


def steepest(lens: PlacedLens, wavelength_nm: F64) -> float:
    """Return the steepest slope of the wavefront, waves per radius."""
    some_nm = np.linspace(wavelength_nm.min(), wavelength_nm.max(), 4)
    return max(rim_of(lens, 0.0, float(nm), np.zeros(2)).inside_waves for nm in some_nm)


def first_nodes(lens: PlacedLens, wavelength_nm: F64, tolerance: float) -> tuple[int, int, int, int]:
    """Return nodes of the rule, shifts, angles and wavelengths that a search for enough of them begins with."""
    # Nodes that a tolerance takes, of those at 1e-5.
    share, steep = max(COARSEST, (3.0 - math.log10(tolerance)) / 8.0), steepest(lens, wavelength_nm)
    rule, shifts, angles, colours = (
        math.ceil(share * fewest) + math.ceil(share * per * steep)
        for fewest, per in zip(FEWEST_NODES, PER_WAVE, strict=True)
    )
    return rule, shifts, angles, colours


def turned(index: tuple[int, ...], waves: F64, angle_rad: F64) -> tuple[list[int], F64]:
    """Return OSA indices, and coefficients (angles, wavefronts, indices) in axes turned by angles.

    waves : (wavefronts, k) of ``index``
    """
    both = sorted({j for own in index for j in (own, own - orders(own)[1])})
    out = np.zeros((angle_rad.size, len(waves), len(both)))
    for own, j in zip(waves.T, index, strict=True):
        m = orders(j)[1]
        # cos m(φ + θ) = cos mθ·cos mφ − sin mθ·sin mφ, and likewise of a sine.
        out[:, :, both.index(j)] += np.multiply.outer(np.cos(m * angle_rad), own)
        if m:
            out[:, :, both.index(j - m)] -= np.multiply.outer(np.sin(m * angle_rad), own)
    return both, out


def _summed(even: F64, odd: F64, weight: F64) -> F64:
    """Return sums (2, wavefronts) of cos and sin of turns (nodes, wavefronts) over nodes and their mirror images."""
    out = np.zeros((2, even.shape[1]))
    shared(even.shape[1], functools.partial(add_nodes, even, odd, weight, out))
    return out


class PlaceSamples:
    """What samples the transfers of a place, less the perfect one's, and finds out how finely.

    A slope knows nothing of how often a wavefront goes up and down. At the hardest wavelength it is looked at what
    more nodes of the rule change, shift by shift, as copies that nearly touch differ by few waves, and so do those that
    hardly move where no order is high. Series in shifts and angles go on until their last terms are quiet, a few of
    them first and then all.

    allowed : of a transfer;  first: nodes of the rule, shifts, angles and wavelengths to begin with
    """

    def __init__(
        self,
        lens: PlacedLens,
        angle_rad: float,
        wavelength_nm: F64,
        *,
        allowed: float,
        first: tuple[int, int, int, int],
    ) -> None:
        self.lens, self.angle_rad, self.wavelength_nm, self.allowed = lens, angle_rad, wavelength_nm, allowed
        rule, self.shifts, self.angles, self.colours = first
        # Tables may have most waves at any wavelength.
        waves = np.abs(lens.coefficients(wavelength_nm)) @ np.array([orders(index)[0] for index in lens.zernike])
        self.hardest = int(np.argmax(waves))
        self.some = 0.5 * math.pi * (np.arange(SOME) + 0.5) / SOME
        # The other quarters look alike. A term cos mθ is steepest in m directions: these are such of all small m.
        self.theta = np.linspace(0.0, 0.5 * math.pi, ROUND)
        # Of a single term cos mθ each 2m-th harmonic is something, where m is even.
        self.last = max(LAST, 1 + 2 * max(abs(orders(index)[1]) for index in lens.zernike))
        self.rules = self._rules(math.ceil(SPARED * rule))

    def taken(self) -> tuple[F64, F64, C128]:
        """Return wavelengths, Gauss nodes of shifts' angles, samples (wavelengths, shifts, 2·angles) all round."""
        hardest, nm = self._followed(), self.wavelength_nm
        shifts, angles = hardest.shape[1:]
        x = gauss_legendre(shifts)[0]
        if nm.size > self.colours:
            nm = self._colours()
            half = self._half_turn(nm, angles_of(x), angles)
        elif nm.size > 1:
            others = self._half_turn(np.delete(nm, self.hardest), angles_of(x), angles)
            half = np.insert(others, self.hardest, hardest[0], axis=0)
        else:
            half = hardest
        return nm, x, np.concatenate([half, half.conj()], axis=-1)

    def _rules(self, fewest: int) -> I64:
        """Return nodes of the rule from one of ``SOME`` shifts to the next, (SOME + 1,)."""
        nm, enough = self.wavelength_nm[[self.hardest]], np.full(self.some.size, fewest)
        for k in range(self.some.size):
            alpha, finer = self.some[[k]], enough[[k]]
            found = self._sampled(nm, alpha, self.theta, finer)
            for _ in range(ROUNDS):
                finer = np.ceil(MORE * finer).astype(np.int64)
                before, found = found, self._sampled(nm, alpha, self.theta, finer)
                if np.abs(found - before).max() <= self.allowed:
                    break
                enough[k] = finer[0]
        rules: I64 = np.maximum(np.append(enough[0], enough), np.append(enough, enough[-1]))
        return rules

    def _followed(self) -> C128:
        """Return the hardest wavelength's samples (1, shifts, angles) over half a turn, as many as follow it."""
        nm = self.wavelength_nm[[self.hardest]]
        for few in (True, False):
            for _ in range(ROUNDS):
                alpha = angles_of(gauss_legendre(self.shifts)[0])
                around = self._half_turn(nm, self.some if few else alpha, self.angles)
                shown = _last_of(self._own(nm, alpha, self.theta) if few else around), _last_round(around, self.last)
                if max(shown) <= self.allowed:
                    break
                self.shifts, self.angles = (
                    math.ceil((MORE if own <= LOUD * self.allowed else MORE**2) * n) if own > self.allowed else n
                    for n, own in zip((self.shifts, self.angles), shown, strict=True)
                )
        return around

    def _colours(self) -> F64:
        """Return wavelengths (n,) that stand for all."""
        nm = self.wavelength_nm
        middle, half = 0.5 * (nm[0] + nm[-1]), 0.5 * np.ptp(nm)
        for _ in range(ROUNDS):
            few_nm: F64 = middle + half * chebyshev(self.colours)
            series = scipy.fft.dct(self._own(few_nm, self.some, self.theta[::FEWER]).view(np.float64), axis=0)
            if np.abs(series[-LAST:]).max() / self.colours <= self.allowed:
                break
            self.colours = math.ceil(MORE * self.colours)
        return few_nm if self.colours < nm.size else nm

    def _half_turn(self, nm: F64, alpha: F64, angles: int) -> C128:
        """Return samples in so many directions over half a turn: on either side of the radius all looks alike."""
        half = angles // 2 + 1
        out = self._own(nm, alpha, math.pi * np.arange(half) / angles)
        return np.concatenate([out, out[..., angles - half : 0 : -1].conj()], axis=-1)

    def _own(self, nm: F64, alpha: F64, theta: F64) -> C128:
        """Return samples (wavelengths, shifts, directions), each with the nodes that its shift takes."""
        return self._sampled(nm, alpha, theta, self.rules[(alpha / (0.5 * math.pi) * SOME + 0.5).astype(np.int64)])

    def _sampled(self, nm: F64, alpha: F64, theta: F64, nodes: I64) -> C128:
        """Return transfers (wavelengths, shifts, directions) less the perfect one's; theta: from the radius.

        nodes : of the rule, for each shift
        """
        index, waves = turned(self.lens.zernike, self.lens.coefficients(nm), self.angle_rad + theta)
        wavefronts = np.ascontiguousarray(waves.reshape(-1, len(index)).T)
        pupil, out = Pupil(), np.empty((nm.size, alpha.size, theta.size), complex)
        rules = []
        for nu, count in zip(np.cos(alpha).tolist(), nodes.tolist(), strict=True):
            x, y, weight = pupil.overlap(2.0 * nu, 0.0, count)
            # On the other half odd polynomials' steps are these, and even ones' turn back.
            half = y > -AXIS
            rules.append((x[half], y[half], weight[half] * np.where(y[half] > AXIS, 2.0, 1.0) / pupil.area))
        first = np.cumsum([0, *(weight.size for *_, weight in rules)])
        x, y, weight = (np.concatenate(parts) for parts in zip(*rules, strict=True))
        shift = np.repeat(np.cos(alpha), np.diff(first))
        steps = np.stack([zernike(j, x - shift, y) - zernike(j, x + shift, y) for j in index])
        odd = np.array([orders(j)[1] % 2 == 1 for j in index])
        for s in range(alpha.size):
            own = slice(first[s], first[s + 1])
            even_turns, odd_turns = (product(steps[which, own].T, wavefronts[which]) for which in (~odd, odd))
            found = _summed(even_turns, odd_turns, weight[own])
            # Less the perfect one's by the same nodes: near a whole pupil they lose some area, of both alike.
            found[0] -= weight[own].sum()
            out[:, s] = (found[0] + 1j * found[1]).reshape(theta.size, nm.size).T
        return out


def angles_of(nodes: F64) -> F64:
    """Return shifts' angles α, ν = cos α, of nodes −1 … 1."""
    alpha: F64 = 0.25 * math.pi * (1.0 + nodes)
    return alpha


def _last_of(samples: C128) -> float:
    """Return the largest of the last Legendre terms along the shifts' angles, of (1, shifts, directions)."""
    count = samples.shape[1]
    x, w = gauss_legendre(count)
    legendre = np.polynomial.legendre.legvander(x, count - 1)[:, -LAST:] * (np.arange(count)[-LAST:] + 0.5)
    terms = product((legendre * w[:, None]).T, np.ascontiguousarray(samples[0]).view(np.float64))
    return float(np.abs(terms.view(complex)).max())


def _last_round(half: C128, last: int) -> float:
    """Return the largest of so many harmonics, the last, of (1, shifts, directions over half a turn)."""
    angles = half.shape[2]
    around = scipy.fft.fft(np.concatenate([half, half.conj()], axis=-1), norm="forward")
    return float(np.abs(around[..., max(angles - last, 0) : angles]).max())
