"""Entries of a capture's report: signal, seconds, accuracy, wavelengths."""

from __future__ import annotations

import time

import numpy as np

from camsim.camera.body import Body
from camsim.camera.exposed_rows import ExposedRows
from camsim.camera.frame import ChannelSignal
from camsim.core.arrays import F32, F64, I64, U16
from camsim.core.note import Note
from camsim.rendering import Rendering
from camsim.sensor.adc import full_codes
from camsim.spectra.light import Light


class Clock:
    """Accumulated seconds by name."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """Add the seconds since the last lap to the total of a name."""
        now = time.perf_counter()
        self.seconds[name] = self.seconds.get(name, 0.0) + now - self._last
        self._last = now


def accuracy_notes(rendering: Rendering) -> tuple[Note, ...]:
    """Return a warning if a rendering is less accurate than requested."""
    worst = max(rendering.error_estimate, rendering.planes_error or 0.0)
    if worst <= rendering.tolerance:
        return ()
    text = (
        f"warning: the error found, {worst:.2g}, is above the tolerance of {rendering.tolerance:g}; "
        "render: {strict: true} or --strict makes that a failure"
    )
    return (Note("error-above-tolerance", text, "render.tolerance"),)


def rounding_notes(truth: F32 | None, diffuser_e: F64, tolerance: float) -> tuple[Note, ...]:
    """Return a warning if single precision is too coarse for a truth (rows, cols, channels) at the tolerance."""
    if truth is None or not truth.size:
        return ()
    exposed = diffuser_e > 0.0
    rounded = truth.max(axis=(0, 1))[exposed] * (0.5 * np.finfo(np.float32).eps) / diffuser_e[exposed]
    if (worst := float(rounded.max(initial=0.0))) <= tolerance:
        return ()
    text = (
        f"warning: truth is in single precision, which rounds its brightest electrons by up to {worst:.2g} of a "
        f"perfect diffuser's; tolerance is {tolerance:g}; mean_electrons holds every digit"
    )
    return (Note("truth-rounded", text, "render.tolerance"),)


class Signals:
    """The signal of every channel, accumulated band by band.

    origin : row and column of the window in the frame
    full_e : mean electrons that fill a photosite: read-out noise scatters the codes of full ones around white
    """

    def __init__(self, camera: Body, origin: tuple[int, int], white_level_dn: int, *, full_e: float) -> None:
        channels = camera.cfa.channels
        self._channels, self._adc, self._origin = channels, camera.converter, origin
        self._white_level_dn, self._full_e, self._cfa_period = white_level_dn, full_e, camera.cfa.period
        self._photosites, self._clipped = np.zeros((2, len(channels)), np.int64)
        self._sum_e, self._max_e, self._sum_dn = np.zeros((3, len(channels)))
        self._min_e = np.full(len(channels), np.inf)

    def add(self, exposed: ExposedRows, mosaic: U16) -> None:
        """Add exposed rows and their data numbers."""
        row, col = self._origin
        offsets_dn = np.array(self._adc.window_black_offsets_dn((row + exposed.rows_before, col)))
        white_dn = full_codes(self._white_level_dn, offsets_dn, self._adc.largest_dn)
        # Filters and offsets are periodic: strided views of a large frame need no copy.
        period = np.lcm(self._cfa_period, white_dn.shape)
        for first_row, first_col in np.ndindex(*np.minimum(period, mosaic.shape).tolist()):
            here = np.s_[first_row :: period[0], first_col :: period[1]]
            electrons, codes, k = exposed.displayed_e[here], mosaic[here], int(exposed.channel[first_row, first_col])
            full_dn = white_dn[first_row % white_dn.shape[0], first_col % white_dn.shape[1]]
            self._photosites[k] += electrons.size
            self._clipped[k] += np.count_nonzero((codes >= full_dn) | (electrons >= self._full_e))
            self._sum_e[k] += np.sum(electrons)
            self._max_e[k] = np.max(electrons, initial=self._max_e[k])
            self._min_e[k] = np.min(electrons, initial=self._min_e[k])
            self._sum_dn[k] += np.sum(codes, dtype=np.float64)

    def _white_dn(self, shape: tuple[int, ...], rows_before: int) -> int | I64:
        """Return the white level: a scalar without offsets, else one for each photosite."""
        if self._adc.black_offsets_dn == ((0,),):
            return min(self._white_level_dn, self._adc.largest_dn)
        row, col = self._origin
        offsets_dn = self._adc.offsets_dn((shape[0], shape[1]), (row + rows_before, col))
        return full_codes(self._white_level_dn, offsets_dn, self._adc.largest_dn)

    def all(self) -> tuple[ChannelSignal, ...]:
        """Return the signal of every channel that has photosites in the window."""
        return tuple(
            ChannelSignal(
                name=name,
                mean_e=float(self._sum_e[k] / self._photosites[k]),
                max_e=float(self._max_e[k]),
                mean_dn=float(self._sum_dn[k] / self._photosites[k]),
                clipped_photosites=int(self._clipped[k]),
                photosites=int(self._photosites[k]),
                min_e=float(self._min_e[k]),
            )
            for k, name in enumerate(self._channels)
            if self._photosites[k]
        )


def wavelengths(light: Light, samples: int, nodes: int) -> str:
    """Return a text on the light, the wavelengths integrated over, and the number of nodes used for the optics."""
    low, high = light.ends_nm
    if light.is_one_line:
        return f"{low:g} nm, one line"
    on_nodes = f" on {nodes} nodes" if nodes else ""  # a uniform field needs no optics
    return f"{low:g}–{high:g} nm, {samples} samples{on_nodes}"
