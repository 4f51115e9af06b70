"""How far ends of edges are heard of what lies between two windows: along a line much cancels that does not at its end.

A pattern K that is parted by frequencies goes up and down. With Δu = K, light of an area is ∮ ∂u/∂n along its outline:
what lies r away of an edge shows about |∇u| times a length that is in phase, √(r/f). The transform of ∂u/∂x + i·∂u/∂y
is −i·T·exp(iθ)/(2πf), summed on a lattice by a non-uniform FFT.
"""

from __future__ import annotations

import math

import numpy as np

from camsim.arrays import C128, F64
from camsim.nonuniform import modes
from camsim.rendering.fast_length import fast_length

STEPS = 2.2  # of the lattice, in the finest wave
WIDEST = 1024  # points along its side: farther out what goes so far are rings, which lines hear as well
FAINT = 1e-3  # of what is allowed: what sums may lose
FINEST = 1e-12  # of them
SILENT = 1e-12  # of a window
SPARE = 30  # directions more than waves and harmonics take
INSIDE = 0.8  # of what is looked at: what is loud as far as that may be so farther on


class Ends:
    """What ends of edges show of a transfer between two windows, looked at as far as it is asked for.

    frequency : (n,) cycles/pitch, even steps from 0 or from the first on;  window: (n,)
    harmonics : (n, 2·most + 1) of exp(imθ)
    """

    def __init__(self, frequency: F64, harmonics: C128, window: F64) -> None:
        some = (window > SILENT) & (frequency > 0.0)
        self._f, self._step = frequency[some], float(frequency[1] - frequency[0])
        self._transfer = harmonics[some] * window[some, None]
        self._in_phase = 1.0 / math.sqrt(np.average(self._f, weights=window[some]))
        self._spacing = 1.0 / (STEPS * float(self._f[-1]))
        self._farthest = min(0.5 / self._step, 0.5 * WIDEST * self._spacing)
        self._looked, self._beyond = 0.0, np.zeros(1)

    def reach(self, allowed: float, nearest: float) -> float:
        """Return from where on they show no more than is allowed, pitches; nearest: as far as lines are heard."""
        looked = min(nearest / INSIDE, self._farthest)
        while True:
            if looked > self._looked:
                self._look(looked, allowed)
            reach = self._spacing * float(np.sum(self._beyond > allowed))
            if reach <= INSIDE * self._looked or self._looked >= self._farthest:
                return reach
            looked = min(2.0 * self._looked, self._farthest)

    def _look(self, looked: float, allowed: float) -> None:
        """Find out what they show from each step of the lattice on."""
        half = math.ceil(looked / self._spacing)
        lost = FAINT * allowed / (self._in_phase * math.sqrt(looked))
        axis = np.arange(2.0 * half) - half
        away = np.hypot(axis[:, None], axis)
        shown = self._slope(2 * half, lost) * (self._in_phase * math.sqrt(self._spacing)) * np.sqrt(away)
        most = np.zeros(2 * half)
        np.maximum.at(most, away.astype(np.int64).ravel(), shown.ravel())
        self._looked, self._beyond = looked, np.maximum.accumulate(most[half - 1 :: -1])[::-1]

    def _slope(self, count: int, lost: float) -> F64:
        """Return |∇u| on a lattice (count, count) about the middle, but for what may be lost."""
        most = self._transfer.shape[1] // 2
        waves = math.tau * float(self._f[-1]) * 0.5 * count * self._spacing
        angles = max(fast_length(most + math.ceil(waves) + SPARE), 2 * most + 1)
        spectrum = np.zeros((self._f.size, angles), complex)
        spectrum[:, : most + 1], spectrum[:, angles - most :] = self._transfer[:, most:], self._transfer[:, :most]
        theta = math.tau * np.arange(angles) / angles
        strengths = np.fft.ifft(spectrum, axis=1, norm="forward") * np.exp(1j * theta) * (self._step / angles)
        turns = math.tau * self._spacing * self._f[:, None]
        at = (turns * np.sin(theta)).ravel(), (turns * np.cos(theta)).ravel()
        precision = min(max(lost / max(float(np.abs(strengths).sum()), 1e-300), FINEST), FAINT)
        size: F64 = np.abs(modes(at, strengths.ravel(), (count, count), precision=precision, sign=1))
        return size
