"""Hankel transforms of cubics against hypergeometric functions of forty digits: ∫ f^m·J_n(2πrf) df has such a form."""

import mpmath as mp
import numpy as np
import pytest

import camsim
from camsim.numerics.hankel import hankel

KNEES = ((0.0, 0.6, 1.8, 2.7, 4.7, 5.0), (1.0, 0.945, 0.546, 0.496, 0.132, 0.0))
STEEP_AT_ZERO = ((0.0, 0.001, 0.1, 0.2), (1.0, 0.97, 0.4, 0.0))
LOBES = (np.linspace(0.0, 0.5, 12), np.append(np.sinc(np.linspace(0.0, 3.6, 11)), 0.0))


def exact(curve, r, order):
    """2π ∫ c(f)·J_n(2πfr)·f^{1−n} df, the cubics written out in powers of f."""
    total = mp.mpf(0)
    for k, (low, high) in enumerate(zip(curve.x[:-1], curve.x[1:], strict=True)):
        about = [mp.mpf(float(c)) for c in curve.c[::-1, k]]
        for m in range(4):
            power = m + 1 - order
            size = sum(about[j] * mp.binomial(j, m) * (-mp.mpf(float(low))) ** (j - m) for j in range(m, 4))
            for u, sign in ((high, 1), (low, -1)):
                top = mp.mpf(power + order + 1)
                form = mp.hyp1f2(top / 2, order + 1, (top + 2) / 2, -((mp.pi * r * mp.mpf(float(u))) ** 2))
                total += sign * size * (mp.pi * r) ** order * mp.mpf(float(u)) ** top / top * form
    return 2 * mp.pi * total


@pytest.mark.parametrize(("frequency", "values"), [KNEES, STEEP_AT_ZERO, LOBES], ids=["knees", "steep at 0", "lobes"])
def test_patterns_and_their_light_however_far_out(frequency, values):
    curve = camsim.RadialOtf(freq_per_um=tuple(frequency), values=tuple(values)).curve()
    radii = np.array([0.3, 4.7, 9.7, 300.2, 3000.7]) / frequency[-1]
    for order in (0, 1):
        # All at once they share rules by groups, alone each has its own.
        found, alone = hankel(curve, radii, order), [float(hankel(curve, r, order)) for r in radii]
        with mp.workdps(40):
            right = [exact(curve, mp.mpf(float(r)), order) for r in radii]
        for one, other, truth, r in zip(found, alone, right, radii, strict=True):
            # A pattern falls as r⁻³, what lies beyond as 1/r; rings pass through zero now and then.
            allowed = 3e-11 * max(abs(float(truth)), 1e-2 * float(r) ** (order - 3.0) * frequency[-1] ** (order - 1.0))
            assert abs(one - truth) <= allowed
            assert abs(other - truth) <= allowed
