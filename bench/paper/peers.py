"""Programs that people would use instead, drawing the same square; each in a process of its own.

GalSim multiplies transforms on a periodic lattice: what is left of the Airy pattern's tail wraps round as an almost
constant error, which ``folding_threshold`` sets. It has boxes and round patterns, no polygons and no OLPF. prysm
convolves a picture of the square with one of the pattern on an oversampled lattice, and bins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from bench.paper.cases import CLOCKED_PSFS, PITCH_UM, SIDE_PX, SIZE, TURN_DEG, WAVELENGTH_NM, Psf, Setting
from camsim.core.arrays import F64
from camsim.errors import UnsupportedError
from camsim.optics import Gaussian

LARGEST_FFT = 32768


@dataclass(frozen=True, slots=True, kw_only=True)
class Peer:
    """A program: its module, the knob, and which systems it can draw (``suits``).

    values  : of the knob, the first ``quick`` of them in a quick run
    draw    : (psf, value of the knob, shift in pitches, lap) → image (rows, cols) of the whole frame
    """

    name: str
    module: str
    knob: str
    values: tuple[float, ...]
    quick: int
    draw: Callable[[Psf, float, Sequence[float], int], F64]
    suits: Callable[[Psf], bool]


def galsim_image(psf: Psf, folding_threshold: float, shift_px: Sequence[float], lap: int) -> F64:
    """Draw with GalSim."""
    import galsim

    how = galsim.GSParams(folding_threshold=folding_threshold, maximum_fft_size=LARGEST_FFT)
    fresh = 1.0 + lap * 1e-11
    if psf.gaussian:
        lens = psf.stages(lap)[0]
        assert isinstance(lens, Gaussian)
        pattern = galsim.Gaussian(sigma=lens.sigma_um / PITCH_UM, gsparams=how)
    else:
        pattern = galsim.Airy(lam_over_diam=WAVELENGTH_NM * 1e-3 * psf.f_number * fresh / PITCH_UM, gsparams=how)
    square = galsim.Box(SIDE_PX, SIDE_PX, flux=SIDE_PX**2, gsparams=how).rotate(TURN_DEG * galsim.degrees)
    scene = galsim.Convolve(square.shift(float(shift_px[0]), float(shift_px[1])), pattern, gsparams=how)
    image = galsim.ImageD(SIZE, SIZE)
    scene.drawImage(image=image, scale=1.0, method="auto" if psf.side_px else "no_pixel")
    drawn: F64 = 1.0 - image.array
    return drawn


def prysm_image(psf: Psf, oversampling: float, shift_px: Sequence[float], lap: int) -> F64:
    """Draw with prysm."""
    from prysm import convolution, coordinates, detector, geometry
    from prysm import psf as patterns

    count, fresh = int(oversampling), 1.0 + lap * 1e-11
    step = 1.0 / count
    x, y = coordinates.make_xy_grid(SIZE * count, dx=step)
    # Its lattice has a sample on the axis; the middle of an even number of photosites lies between samples.
    dx, dy = 0.5 * step - float(shift_px[0]), 0.5 * step - float(shift_px[1])
    square = geometry.rectangle(0.5 * SIDE_PX, x + dx, y + dy, angle=-TURN_DEG).astype(float)
    with np.errstate(invalid="ignore"):  # it divides by the middle's zero and mends that afterwards
        pattern = patterns.airydisk(np.hypot(x, y) * PITCH_UM, psf.f_number * fresh, WAVELENGTH_NM * 1e-3)
    drawn: F64 = 1.0 - detector.bindown(convolution.conv(square, pattern / pattern.sum()), count)
    return drawn


PEERS = {
    peer.name: peer
    for peer in (
        Peer(
            name="GalSim",
            module="galsim",
            knob="folding_threshold",
            values=(5e-3, 5e-4, 2e-4, 1e-4),
            quick=3,
            draw=galsim_image,
            suits=lambda psf: not psf.green and psf.split_px == 0.0,
        ),
        Peer(
            name="prysm",
            module="prysm",
            knob="oversampling",
            values=(3.0, 9.0),
            quick=1,
            draw=prysm_image,
            suits=lambda psf: not psf.green and not psf.gaussian and psf.split_px == 0.0 and psf.side_px == 1.0,
        ),
    )
}


def installed_peers() -> list[Peer]:
    """Return the programs that are there; UnsupportedError when none is."""
    found = [peer for peer in PEERS.values() if find_spec(peer.module) is not None]
    if not found:
        raise UnsupportedError(
            f"none of {', '.join(peer.module for peer in PEERS.values())} is installed; "
            "add them with: python -m pip install 'camsim-spectral[bench]'",
            key="--peers",
        )
    return found


def settings_of_peer(peer: Peer, psf: Psf, *, quick: bool = False) -> list[Setting]:
    """Return the peer's settings for a system: what takes seconds and gigabytes on one of each kind, not when quick."""
    if not peer.suits(psf):
        return []
    values = peer.values if psf.name in CLOCKED_PSFS and not quick else peer.values[: peer.quick]
    return [Setting(program=peer.name, method=peer.knob, knob=value) for value in values]
