"""The oscillatory part of a diffraction pattern's far form: the ringing of an edge's end, or of a line.

1 − E = (smooth powers of 1/r) + Re Σ G(r) over a few oscillations, G = e^{2πir/l}·(a₀·(l/r)² + a₁·(l/r)³ + …); an Airy
pattern has one, of length l = λN. G is analytic and decays off the real axis, so the integral along an edge, from its
end to infinity, can be deformed into the complex plane. On the ray s + e^{iπ/4}·ξ the integrand decays within a few
√(l·r) in every direction, even where the edge is perpendicular to the line of sight, and a dozen Gauss nodes suffice.

The footprint enters exactly. Averaged over it the field is e^{2πir/l}·r⁻³·A(1/r, θ), with A smooth in 1/r and
band-limited in θ by the footprint's size over l. A is computed once by a product rule over the footprint, as a
polynomial in 1/r and a Fourier series in 2θ (a footprint is symmetric about its centre) or in 4θ (if it is symmetric
under a quarter turn); both extend analytically off the real axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from camsim.core.arrays import C128, F64
from camsim.core.kernels import kernel
from camsim.numerics.quadrature import gauss_legendre, gauss_phases, gauss_rules
from camsim.optics.pattern import Tone

RAY_NODES = 14
RAY_DECAY = 16.0  # nepers along the ray
_RAY_X, _RAY_W = 0.5 * (1.0 + gauss_legendre(RAY_NODES)[0]), 0.5 * gauss_legendre(RAY_NODES)[1]
MOST_ON_PIECES = 12  # nodes, fewer than on two rays
ON_PIECES, FINEST, COARSEST = 0.1, 1e-10, 1e-5  # relative error of a wave: over the tolerance, and its limits
PIECE_X, PIECE_W, _ = gauss_rules(tuple(range(MOST_ON_PIECES + 1)))
_RAY = complex(math.sqrt(0.5), math.sqrt(0.5))


def oscillation_lengths(oscillations: Sequence[Tone], blur: F64) -> F64:
    """Return the lengths (oscillations · j,) of every oscillation at every wavelength, pitches; blur: (j,) λN."""
    return np.concatenate([np.empty(0), *(blur / u for u, _ in oscillations)])


def ring_terms(extent: float, shortest: float, *, turns: int, nearest: float) -> tuple[int, int]:
    """Return how many harmonics and powers resolve the shortest oscillation over a footprint of size ``extent``."""
    ripple = 2.0 * math.pi * extent / shortest  # radians across the footprint
    powers = 6 + math.ceil(0.5 * ripple * extent / nearest)
    # Bessel functions of order n vanish from n = ripple on, within a few times its third root.
    most = math.ceil((ripple + 4.0 * ripple ** (1.0 / 3.0) + 8.0) / turns)
    return 2 * most + 1, powers


def ring_amplitudes(
    oscillations: Sequence[Tone], blur: F64, nodes: F64, weights: F64, *, turns: int, nearest: float
) -> C128:
    """Tabulate the amplitudes of oscillations averaged over a footprint.

    blur    : (j,) λN, pitches
    nodes   : (n, 2), weights (n,): a rule over the footprint that resolves λN
    turns   : 2, or 4 if the footprint is symmetric under a quarter turn
    nearest : pitches; amplitudes are valid from there on, with a relative error of 1e-6
    returns : (oscillations · j, 2, m, q): radial and tangential, harmonics of turns·θ from −(m − 1)/2 on, powers of
              nearest/r
    """
    extent = float(np.hypot(nodes[:, 0], nodes[:, 1]).max())
    lengths = oscillation_lengths(oscillations, blur)
    count, powers = ring_terms(extent, float(lengths.min()), turns=turns, nearest=nearest)
    most = count // 2
    angle = 2.0 * np.pi / turns * np.arange(count) / count
    inverse = 0.5 * (1.0 + np.cos(np.pi * (np.arange(powers) + 0.5) / powers))
    to_powers = np.linalg.inv(np.vander(inverse, powers, increasing=True))
    amplitude = np.empty((lengths.size, 2, count, powers), np.complex128)
    for j, length in enumerate(lengths.tolist()):
        u, series = oscillations[j // blur.size]
        one = np.array([a * u ** (2 + k) for k, a in enumerate(series)], np.complex128)
        samples = _amplitude(length, one, nodes, weights, nearest / inverse, angle)
        harmonics = np.roll(np.fft.fft(samples, axis=2) / count, most, axis=2)
        # A slow oscillation has few harmonics. Rounding in the others would grow as e^{2m·Im θ} off the real axis,
        # where the ray of a slow oscillation extends farthest.
        its_most = ring_terms(extent, length, turns=turns, nearest=nearest)[0] // 2
        harmonics[..., : most - its_most] = harmonics[..., most + its_most + 1 :] = 0.0
        amplitude[j] = np.einsum("pq,cqm->cmp", to_powers, harmonics)
    return amplitude


@kernel(allocates=True)
def _amplitude(length: float, series: C128, nodes: F64, weights: F64, radius: F64, angle: F64) -> C128:
    """Field averaged over the footprint, times r³·e^{−2πir/l}: (2, radii, angles), radial and tangential."""
    out = np.zeros((2, radius.size, angle.size), np.complex128)
    for q in range(radius.size):
        r = radius[q]
        for m in range(angle.size):
            c, s = math.cos(angle[m]), math.sin(angle[m])
            for n in range(weights.size):
                outwards = nodes[n, 0] * c + nodes[n, 1] * s
                across = nodes[n, 1] * c - nodes[n, 0] * s
                distance = math.hypot(r + outwards, across)
                excess = (2.0 * r * outwards + outwards**2 + across**2) / (distance + r)
                inverse = length / distance
                ring = 0j
                for k in range(series.size - 1, -1, -1):
                    ring = ring * inverse + series[k]
                phase = 2.0 * math.pi * excess / length
                field = ring * complex(math.cos(phase), math.sin(phase))
                field *= -weights[n] * r**3 * inverse**2 / (2.0 * math.pi * distance**2)
                out[0, q, m] += field * (r + outwards)
                out[1, q, m] += field * across
    return out


def left_of_waves(tolerance: float) -> float:
    """Return the relative error of a wave for quadrature on pieces and for look-ups.

    It is relative to ringing that is at most a thousandth of full scale.
    """
    return min(max(ON_PIECES * tolerance, FINEST), COARSEST)


def piece_phases(tolerance: float) -> F64:
    """Return half of the phase (MOST_ON_PIECES,) along a piece that 1, 2 … nodes resolve."""
    return gauss_phases(left_of_waves(tolerance), MOST_ON_PIECES)


def piece_nodes(length: F64, shortest: float, tolerance: float) -> F64:
    """Return how many nodes resolve the shortest oscillation along edges (n,); 0 for those that are too long."""
    phases, phase = piece_phases(tolerance), math.pi * length / shortest
    nodes: F64 = np.where(phase <= phases[-1], np.searchsorted(phases, phase) + 1.0, 0.0)
    return nodes


@kernel(forceinline=True)
def _followed(u: complex, turn: complex, j: int, amplitude: C128) -> tuple[complex, complex]:
    """Return an oscillation's amplitudes, radial and tangential, times the harmonic ``turn`` to half their number."""
    radial, tangential = 0j, 0j
    for m in range(amplitude.shape[2] - 1, -1, -1):
        a, b = 0j, 0j
        for q in range(amplitude.shape[3] - 1, -1, -1):
            a = a * u + amplitude[j, 0, m, q]
            b = b * u + amplitude[j, 1, m, q]
        radial = radial * turn + a
        tangential = tangential * turn + b
    return radial, tangential


@kernel(forceinline=True)
def nodes_on(half: float, length: float, phases: F64) -> int:
    """Return how many nodes resolve an oscillation on a piece of half length ``half``; phases: of ``piece_phases``."""
    phase, count = 2.0 * math.pi / length * half, 1
    while count < MOST_ON_PIECES and phases[count - 1] < phase:
        count += 1
    return count


@kernel()
def ring_part(
    h: float,
    ends: tuple[float, float],
    way: complex,
    weights: F64,
    lengths: F64,
    amplitude: C128,
    turns: int,
    nearest: float,
    phases: F64,
) -> float:
    """Oscillatory part of a piece of a line from s₁ to s₂ that is short (``is_short``).

    phases : of ``piece_phases``

    The integrand is that of ``ring_tail`` on the real axis: |dr/ds| ≤ 1, so no wave along the piece is shorter than λN.
    """
    total, (s1, s2) = 0.0, ends
    middle, half = 0.5 * (s1 + s2), 0.5 * (s2 - s1)
    for j in range(lengths.size):
        weight = weights[j % weights.size]
        if weight == 0.0:
            continue
        wave = 2.0 * math.pi / lengths[j]
        count, sum_j = nodes_on(half, lengths[j], phases), 0.0
        for i in range(count):
            along = middle + half * PIECE_X[count, i]
            r = math.sqrt(h * h + along * along)
            turn = way * complex(along, -h) / r
            turn *= turn
            if turns == 4:
                turn *= turn
            radial, tangential = _followed(nearest / r, turn, j, amplitude)
            back, phase = 1.0 + 0j, wave * r
            for _ in range((amplitude.shape[2] - 1) // 2):
                back *= turn.conjugate()
            rise = (h * radial - along * tangential) * complex(math.cos(phase), math.sin(phase)) * back
            sum_j += PIECE_W[count, i] * rise.real / (r * r * r * r)
        total += weight * sum_j * half
    return total


@kernel(forceinline=True)
def is_short(length: float, shortest: float, phases: F64) -> bool:
    """Return whether a piece is short enough for ``ring_part``; shortest: oscillation's length;  phases: as there."""
    short: bool = math.pi * length <= phases[MOST_ON_PIECES - 1] * shortest
    return short


@kernel()
def ring_tail(
    h: float, s: float, tx: float, ty: float, weights: F64, lengths: F64, amplitude: C128, turns: int, nearest: float
) -> float:
    """Oscillatory part of the half line from s ≥ 0 on in direction (tx, ty), for a photosite at h to its left.

    weights : (j,) of wavelengths;  lengths: of ``oscillation_lengths``;  the rest as of ``ring_amplitudes``

    It is ∫ −V·n ds along the ray, n = (−ty, tx), with V from its radial and tangential amplitudes.
    """
    total = 0.0
    r = math.hypot(h, s)
    harmonics = amplitude.shape[2]
    for j in range(lengths.size):
        weight = weights[j % weights.size]
        if weight == 0.0:
            continue
        wave = 2.0 * math.pi / lengths[j]
        # Im r on the ray is at least (√2·s·ξ + ξ²)/(2(r + ξ)); solved with r for r + ξ, for which RAY_DECAY allows.
        fall = 2.0 * r * RAY_DECAY / wave
        length = fall / (s * math.sqrt(0.5) + math.sqrt(0.5 * s * s + fall))
        sum_j = 0j
        for i in range(_RAY_X.size):
            along = s + _RAY * (length * _RAY_X[i])
            rr = np.sqrt(h * h + along * along)
            inverse = 1.0 / rr
            turn = complex(tx, ty) * ((along - 1j * h) * inverse)  # e^{iθ}, on and off the real axis
            turn *= turn
            if turns == 4:
                turn *= turn
            back = 1.0 / turn
            u = nearest * inverse
            radial, tangential = _followed(u, turn, j, amplitude)
            rise = (h * radial - along * tangential) * inverse**4 * np.exp(1j * wave * rr)
            sum_j += _RAY_W[i] * rise * back ** ((harmonics - 1) // 2)
        total += weight * (sum_j * _RAY).real * length
    return total
