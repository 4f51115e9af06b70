"""Parts of the judge of demosaicing, on pictures made by hand whose answer can be counted."""

import numpy as np

from camsim.measure.demosaic.alignment import best_shift
from camsim.measure.demosaic.artefacts import artefacts
from camsim.measure.demosaic.phases import order_fault
from camsim.measure.demosaic.scaling import scaled
from camsim.measure.demosaic.subject import Subject
from camsim.sensor.colour_matrix import XYZ_D50

ROWS, COLS = 24, 40
SIDE = 64
NEUTRAL = np.array([0.5, 1.0, 0.7])


def subject_of(grey):
    """A grey picture, all of it judged, of a camera whose channels answer white differently."""
    truth = np.repeat(grey[..., None], 3, axis=2).astype(np.float32)
    return Subject(
        name="made",
        truth=truth,
        used=np.ones(grey.shape, bool),
        neutral=NEUTRAL,
        to_xyz=np.diag(np.asarray(XYZ_D50)),
        cfa=("RG", "GB"),
    )


def smooth():
    y, x = np.indices((ROWS, COLS))
    return 0.4 + 0.2 * np.sin(x / 7.0) + 0.1 * np.cos(y / 5.0)


def test_zippers_are_counted_at_both_ends():
    """Columns in pairs, and rows far apart: one photosite in error unlike its only like neighbour makes two zippers."""
    pairs = np.arange(COLS) // 2
    subject = subject_of(0.1 + 0.02 * pairs[None, :] + 0.3 * (np.arange(ROWS) % 3)[:, None] / 2)
    for col in (11, 12):
        found = subject.truth.copy()
        found[5, col] *= 1.3
        assert artefacts(found, subject).zipper * ROWS * COLS == 2


def test_noise_looks_like_no_order_of_filters(rng):
    subject = subject_of(smooth())
    for _ in range(12):
        found = rng.random((ROWS, COLS, 3)).astype(np.float32)
        assert order_fault(found, subject) is None


def test_what_noise_may_do_is_no_fault(rng):
    """Ground that is all but even, grainy: its tenth of a thousand tells neither a shift nor balances of 3 %."""
    y, x = np.indices((SIDE, SIDE))
    subject = subject_of(0.05 + 5e-6 * x + 3e-6 * y)
    for _ in range(12):
        found = subject.truth + rng.normal(0.0, 0.02, (SIDE, SIDE, 3)).astype(np.float32)
        assert best_shift(found, subject) == (0.0, 0.0)
        assert not scaled(found, subject).faults
