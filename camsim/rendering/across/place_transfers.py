"""The check's transfers at one place of the frame, by rules, shifts, angles and wavelengths of its own.

T(ν, θ) = (1/π)·∫ exp(2πi·[W(p − d) − W(p + d)]) dp over what two copies of the pupil have in common. In axes along the
shift that region is the same in all directions, and the wavefront turns: polynomials are asked once for each shift.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy

from camsim.arrays import C128, F64, I64
from camsim.kernels import shared
from camsim.optics.airy import NM_PER_UM
from camsim.optics.difference import rim_of
from camsim.optics.placed import PlacedLens
from camsim.optics.pupil import Pupil
from camsim.optics.zernike import orders, zernike
from camsim.products import complex_product, product
from camsim.quadrature import barycentric, chebyshev, gauss_legendre, interpolation
from camsim.rendering.across.judge_kernels import add_nodes

FEWEST_NODES = (14, 28, 20, 16)  # of the overlap's rule, shifts, half a circle of angles, wavelengths
PER_WAVE = (1.1, 1.7, 1.6, 2.2)  # of the steepest slope, waves per radius: nodes more to begin with, at 1e-5
AT_ONCE = 256  # frequencies
COARSEST = 0.7  # of them, at 2e-3 and more
EACH = 0.02  # of the tolerance: what a transfer may lose by the rule, and by each of the others' last terms
FINEST = 2e-10  # of a transfer: sums of cosines that are known to 2e-11
MORE, LAST = 1.25, 5  # times as many nodes where it loses more; terms that are looked at: some are 0 by symmetry
LOUD = 100.0  # times what is allowed: past that, by as much again
SOME = (8, 4)  # shifts and angles at which rules are compared
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


def _between(rules: I64, alpha: F64) -> I64:
    """Return nodes of the rule at shifts' angles α, by those from one of ``SOME`` to the next."""
    nodes: I64 = rules[(alpha / (0.5 * math.pi) * SOME[0] + 0.5).astype(np.int64)]
    return nodes


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaceTransfers:
    """Transfers of one place, less the perfect one's, for sets of weights (sets, wavelengths).

    angle_rad : of the place about the axis: a lens of revolution looks alike on both sides of the radius
    """

    lens: PlacedLens
    angle_rad: float
    wavelength_nm: F64
    weights: F64
    tolerance: float

    @functools.cached_property
    def _nodes(self) -> tuple[I64, int, int, int]:
        """Nodes of the rule from one of ``SOME`` shifts to the next, (SOME + 1,), of shifts, angles and wavelengths.

        A slope knows nothing of how often a wavefront goes up and down: at the shortest wavelength it is looked at what
        more nodes of the rule change, shift by shift, as copies that nearly touch differ by few waves, and so do those
        that hardly move where no order is high. Series of the others go on until their last terms are quiet.
        """
        rule, shifts, angles, colours = first_nodes(self.lens, self.wavelength_nm, self.tolerance)
        loud = float(np.abs(self.weights).sum(axis=1).max())
        allowed, nm = max(EACH * self.tolerance / max(loud, 1e-300), FINEST), self.wavelength_nm[:1]
        some, theta = (0.5 * math.pi * (np.arange(n) + 0.5) / n for n in SOME)
        enough = np.full(some.size, math.ceil(SPARED * rule))
        for k in range(some.size):
            found, finer = self._sampled(nm, some[[k]], 2.0 * theta, enough[[k]]), enough[[k]]
            for _ in range(ROUNDS):
                finer = np.ceil(MORE * finer).astype(np.int64)
                before, found = found, self._sampled(nm, some[[k]], 2.0 * theta, finer)
                if np.abs(found - before).max() <= allowed:
                    break
                enough[k] = finer[0]
        rules = np.maximum(np.append(enough[0], enough), np.append(enough, enough[-1]))
        for _ in range(ROUNDS):
            x, w = gauss_legendre(shifts)
            half = self._on_half_turn(nm, 0.25 * math.pi * (1.0 + x), angles, rules)[0]
            around = scipy.fft.fft(np.concatenate([half, half.conj()], axis=-1), norm="forward")[
                :, angles - LAST : angles
            ]
            legendre = np.polynomial.legendre.legvander(x, shifts - 1)[:, -LAST:] * (np.arange(shifts)[-LAST:] + 0.5)
            terms = product((legendre * w[:, None]).T, half.view(np.float64)).view(complex)
            shown = np.abs(terms).max(), np.abs(around).max()
            if max(shown) <= allowed:
                break
            shifts, angles = (
                math.ceil((MORE if own <= LOUD * allowed else MORE**2) * n) if own > allowed else n
                for n, own in zip((shifts, angles), shown, strict=True)
            )
        for _ in range(ROUNDS if self.wavelength_nm.size > colours else 0):
            own = chebyshev(colours)
            nm = 0.5 * (self.wavelength_nm[0] + self.wavelength_nm[-1]) + 0.5 * np.ptp(self.wavelength_nm) * own
            sampled = self._sampled(nm, some, 2.0 * theta, _between(rules, some))
            series = scipy.fft.dct(sampled.view(np.float64), axis=0)
            if np.abs(series[-LAST:]).max() / colours <= allowed:
                break
            colours = math.ceil(MORE * colours)
        return rules, shifts, angles, colours

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

    def _on_half_turn(self, nm: F64, alpha: F64, angles: int, rules: I64) -> C128:
        """Return the same in so many directions over half a turn: on either side of the radius all looks alike."""
        half = angles // 2 + 1
        out = self._sampled(nm, alpha, math.pi * np.arange(half) / angles, _between(rules, alpha))
        return np.concatenate([out, out[..., angles - half : 0 : -1].conj()], axis=-1)

    @functools.cached_property
    def _samples(self) -> tuple[F64, F64, C128]:
        """Shifts' angles α, ν = cos α; wavelengths; samples (wavelengths, shifts, 2·angles) all round."""
        rules, shifts, angles, colours = self._nodes
        nm = self.wavelength_nm
        if nm.size > colours:
            nm = 0.5 * (nm[0] + nm[-1]) + 0.5 * (nm[-1] - nm[0]) * chebyshev(colours)
        alpha = 0.25 * math.pi * (1.0 + gauss_legendre(shifts)[0])
        out = self._on_half_turn(nm, alpha, angles, rules)
        return alpha, nm, np.concatenate([out, out.conj()], axis=-1)

    @functools.cached_property
    def _harmonics(self) -> tuple[I64, C128]:
        samples = self._samples[2]
        count = samples.shape[-1]
        spectrum = scipy.fft.fft(samples, axis=-1) / count
        m = np.arange(-(count // 2) + 1, count // 2)
        return m, spectrum[..., m]

    @functools.cached_property
    def _at_wavelengths(self) -> F64:
        """Harmonics (wavelengths, shifts, 2·m), real and imaginary parts in turn, at every wavelength."""
        nm, (_, harmonics) = self._samples[1], self._harmonics
        low, high = self.wavelength_nm[0], self.wavelength_nm[-1]
        own = np.eye(nm.size)
        if nm.size < self.wavelength_nm.size:
            own = interpolation(chebyshev(nm.size), (2.0 * self.wavelength_nm - low - high) / (high - low))
        pairs = np.ascontiguousarray(harmonics).view(np.float64)
        return product(own, pairs.reshape(nm.size, -1)).reshape(-1, *pairs.shape[1:])

    def on(self, frequency_per_um: F64, theta: F64) -> C128:
        """Return transfers (sets, directions, frequencies)."""
        m, _ = self._harmonics
        fused = self._over(frequency_per_um)
        around = np.exp(1j * np.multiply.outer(theta - self.angle_rad, m))
        return np.stack([complex_product(around, own) for own in fused])

    def _over(self, frequency_per_um: F64) -> C128:
        """Return harmonics (sets, m, frequencies), wavelengths added up; kept for the next directions."""
        key = frequency_per_um.size, float(frequency_per_um[0])
        if key not in self._kept:
            alpha = self._samples[0]
            x, w = gauss_legendre(alpha.size)
            signs = (-1.0) ** np.arange(x.size) * np.sqrt((1.0 - x * x) * w)
            scale = self.lens.f_number * self.wavelength_nm / NM_PER_UM
            samples = self._at_wavelengths.reshape(-1, self._at_wavelengths.shape[-1])
            fused = np.empty((len(self.weights), frequency_per_um.size, self._harmonics[0].size), complex)
            for first in range(0, frequency_per_um.size, AT_ONCE):
                part = slice(first, first + AT_ONCE)
                nu = np.multiply.outer(frequency_per_um[part], scale)
                at = np.zeros((*nu.shape, x.size))
                at[nu < 1.0] = barycentric(x, signs, np.arccos(nu[nu < 1.0]) / (0.25 * math.pi) - 1.0, same=1e-14)
                for own, weights in zip(fused, self.weights, strict=True):
                    # Two real numbers for a complex one, all wavelengths at once: one product of matrices.
                    own[part] = product((at * weights[:, None]).reshape(len(nu), -1), samples).view(complex)
            self._kept[key] = np.moveaxis(fused, 2, 1)
        return self._kept[key]

    @functools.cached_property
    def _kept(self) -> dict[tuple[int, float], C128]:
        return {}
