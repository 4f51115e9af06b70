"""Single Zernike terms, which mixtures hide: nodes may lie where one is nothing, or is the same everywhere."""

from __future__ import annotations

SINGLES = 1000  # seeds from here on, dates among them, draw them; what those before drew stays as it was
ORDERS = 1, 20
FULL = 8  # the order from which on waves fall as its square, and slopes stay


def single(rng, sines):
    """OSA indices of one term of some order, or two, and how much of the waves that order 8 may have is theirs."""
    order = int(rng.integers(ORDERS[0], ORDERS[1] + 1))
    indices = [(order * (order + 2) + m) // 2 for m in range(-order, order + 1, 2) if sines or m >= 0]
    count = min(int(rng.choice([1, 1, 2])), len(indices))
    return sorted(rng.choice(indices, count, replace=False).tolist()), min(1.0, (FULL / order) ** 2)
