"""Light that has a closed form or a single integral: discs, Gaussian strips, edges seen from far away."""

import math

import numpy as np
from scipy import special


def disc_by_frequencies(radius, lambda_n, distance):
    """Light of a white disc on black at a point: ∫ OTF(k)·R·J1(2πkR)·J0(2πk·distance)·2π dk up to the cut-off."""
    x, w = np.polynomial.legendre.leggauss(20)
    panels = int(4 * (radius + distance) / lambda_n) + 8
    u = ((np.arange(panels)[:, None] + 0.5 * (1.0 + x)) / panels).ravel()
    du = np.tile(0.5 * w / panels, panels)
    otf = 2.0 / np.pi * (np.arccos(u) - u * np.sqrt(1.0 - u * u))
    k = u / lambda_n
    wave = special.j1(2.0 * np.pi * k * radius) * special.j0(2.0 * np.pi * k * distance)
    return float(np.sum(otf * wave * du)) * 2.0 * np.pi * radius / lambda_n


def disc_at_its_centre(radius, lambda_n):
    """Its encircled energy, 1 − J0² − J1² (Rayleigh)."""
    x = math.pi * radius / lambda_n
    return 1.0 - special.j0(x) ** 2 - special.j1(x) ** 2


def grating_contrast(frequency, lambda_n, side, split):
    """What a lens, a square photosite and an OLPF of four spots leave of a wave of frequency (fx, fy)."""
    u = min(math.hypot(*frequency) * lambda_n, 1.0)
    lens = 2.0 / math.pi * (math.acos(u) - u * math.sqrt(1.0 - u * u))
    return lens * math.prod(float(np.sinc(f * side)) * math.cos(math.pi * f * split) for f in frequency)


def knife_edge(waves, lambda_n, distance, towards_deg, side, nodes=120):
    """Light of a white half-plane on black, ``distance`` beyond its edge, through a round pupil: ½ + ∫ Im T·e/πf df.

    waves : (x, y) → path difference over the unit disc.  The transfer T along the edge's normal, away from the black,
    is the overlap of two pupils 2·λN·f apart, summed along chords; its ends in y are square roots, which y = Y·sin t
    takes.
    """
    cos, sin = math.cos(math.radians(towards_deg)), math.sin(math.radians(towards_deg))
    x, w = np.polynomial.legendre.leggauss(nodes)
    f, df = 0.5 * (1.0 + x) / lambda_n, 0.5 * w / lambda_n
    transfer = np.empty(nodes, complex)
    for k, shift in enumerate(lambda_n * f):
        most = math.sqrt(1.0 - shift * shift)
        y = most * np.sin(0.5 * np.pi * x)
        half = np.sqrt(1.0 - y * y) - shift
        u, v = half[:, None] * x, np.broadcast_to(y[:, None], (nodes, nodes))
        weight = (0.5 * np.pi * most * np.cos(0.5 * np.pi * x) * w * half)[:, None] * w
        one, two = (waves((u + d) * cos - v * sin, (u + d) * sin + v * cos) for d in (-shift, shift))
        transfer[k] = np.sum(weight * np.exp(2j * np.pi * (one - two))) / np.pi
    seen = transfer * np.sinc(side * f * cos) * np.sinc(side * f * sin) * np.exp(2j * np.pi * f * distance)
    return 0.5 + float(np.sum(df * seen.imag / (np.pi * f)))
