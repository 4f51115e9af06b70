"""The far light of a pupil with straight sides: spikes along the sides' normals.

By Stokes' theorem an amplitude is an integral along the pupil's outline. From a side of length ℓ with normal n comes
(n·ν)/(2πi|ν|²)·∫exp(2πi(W(l) − l·ν_t)) dl, with ν = r/2λN and ν_t its part along the side. Along ±n its light falls as
1/ν², and across it keeps its profile, |∫…|², as wide as λN however far out. Opposite sides interfere, light lies
between the spikes as well, and a wavefront moves parts of a spike: all that falls by a power of λN/r faster.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camsim.arrays import C128, F64
from camsim.optics.pupil import Pupil
from camsim.quadrature import gauss_legendre

STEP = 1e-4  # half diameters, of a slope
OUTWARD = 12  # places between the middle of a pupil and a side where its slope is looked at
NODES, PER_WAVE, PROBES = 24, 6, 65  # along a side, and more for every wave that its path difference goes up and down


class Aberrated(Protocol):
    """A pupil with a path difference."""

    @property
    def pupil(self) -> Pupil: ...  # noqa: D102

    def blur_um(self, wavelength_nm: float) -> float: ...  # noqa: D102

    def waves(self, x: F64, y: F64, wavelength_nm: float) -> F64: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spike:
    """The light that one side throws along its normal and, as much, the other way.

    along, across : unit vectors (2,), the side's normal and the side
    light_um : light per µm at a distance s along either way is this over s²
    moved_um : (2,) how far along the normal and along the side the middle of both is moved
    spread_um : (2,) how far parts of the side are moved about that, root mean square
    spot_um : how far any part of the pupil between this side and the middle is moved
    cutoff_per_um : where the transfer of the profile ends;  ends: (2, 2) of the side, half diameters
    """

    along: F64
    across: F64
    light_um: float
    moved_um: tuple[float, float]
    spread_um: tuple[float, float]
    spot_um: float
    cutoff_per_um: float
    ends: F64
    lens: Aberrated
    wavelength_nm: float

    def transfer(self, freq_per_um: F64) -> C128:
        """Return the transform (n,) of the profile across the spike at frequencies of 0 or more, 1 at 0."""
        shift = freq_per_um / self.cutoff_per_um  # shares of the side that two copies of the pupil are apart
        up_and_down = float(np.abs(np.diff(self._waves(np.linspace(0.0, 1.0, PROBES)))).sum())
        t, weight = gauss_legendre(NODES + int(PER_WAVE * up_and_down))
        both = np.maximum(1.0 - shift, 0.0)
        first = np.multiply.outer(both, 0.5 * (1.0 + t))
        turned = self._waves(first) - self._waves(first + shift[:, None])
        transfer: C128 = both * (np.exp(2j * np.pi * turned) @ (0.5 * weight))
        return transfer

    def _waves(self, share: F64) -> F64:
        """Return the path difference at shares of the side's length, waves."""
        x, y = (a + share * (b - a) for a, b in zip(*self.ends, strict=True))
        return self.lens.waves(x, y, self.wavelength_nm)


def spikes_of(lens: Aberrated, wavelength_nm: float) -> tuple[Spike, ...]:
    """Return a spike for every side of a polygon; none of a round pupil, nor of one with an obstruction.

    >>> from camsim.optics import Pupil, Wavefront
    >>> square = spikes_of(Wavefront(f_number=8.0, pupil=Pupil(shape="square")), 550.0)
    >>> [round(2.0 * spike.light_um / 4.4, 6) for spike in square]  # 2/π² λN/r is beyond r, as behind a circle
    [0.050661, 0.050661, 0.050661, 0.050661]
    """
    pupil = lens.pupil
    if pupil.obstruction:
        return ()
    blur_um, found = lens.blur_um(wavelength_nm), []
    t, weight = gauss_legendre(NODES)
    outward = np.linspace(1.0, 0.0, OUTWARD)[:, None]  # the first are on the side itself
    for begin, end in zip(pupil.corners, np.roll(pupil.corners, -1, axis=0), strict=True):
        length = float(np.hypot(*(end - begin)))
        across = (end - begin) / length
        along = np.array([across[1], -across[0]])
        x, y = begin[:, None, None] + np.multiply.outer(end - begin, np.tile(0.5 * (1.0 + t), (OUTWARD, 1)))
        x, y = outward * x, outward * y
        slopes = []
        for dx, dy in (STEP * along, STEP * across):
            rise = lens.waves(x + dx, y + dy, wavelength_nm) - lens.waves(x - dx, y - dy, wavelength_nm)
            slopes.append(blur_um * rise / STEP)  # a wave across half a diameter moves the pattern by 2λN
        moved = [0.5 * float(weight @ slope[0]) for slope in slopes]
        spread = [float(np.sqrt(0.5 * weight @ (slope[0] - m) ** 2)) for slope, m in zip(slopes, moved, strict=True)]
        found.append(
            Spike(
                along=along,
                across=across,
                light_um=length * blur_um / (2.0 * np.pi**2 * pupil.area),
                moved_um=(moved[0], moved[1]),
                spread_um=(spread[0], spread[1]),
                spot_um=float(np.hypot(*slopes).max()),
                cutoff_per_um=0.5 * length / blur_um,
                ends=np.stack([begin, end]),
                lens=lens,
                wavelength_nm=wavelength_nm,
            )
        )
    return tuple(found)
