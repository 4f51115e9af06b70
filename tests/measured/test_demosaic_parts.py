"""Parts of the judge of demosaicing, on pictures made by hand whose answer can be counted."""

import math

import numpy as np
import pytest

from camsim.files.preview import demosaic
from camsim.measure.demosaic.alignment import best_shift
from camsim.measure.demosaic.artefacts import artefacts
from camsim.measure.demosaic.phases import order_fault
from camsim.measure.demosaic.scaling import scaled
from camsim.measure.demosaic.subject import Subject
from camsim.sensor.cfa import Cfa
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


def test_black_is_looked_for_on_even_ground_of_a_wide_picture():
    grey = np.where(np.arange(COLS) < COLS // 2, 0.2, 0.6) * np.ones((ROWS, 1))
    subject = subject_of(grey)
    found = scaled(np.float32(2.0) * subject.truth + np.float32(0.1), subject)
    assert [fault.sentence for fault in found.faults] == [
        "black has +5.0% of a diffuser's level; subtract the black level"
    ]
    assert not scaled(np.float32(2.0) * subject.truth, subject).faults


def test_the_order_of_filters_is_told_by_their_answer_to_white():
    """Of a smooth grey picture nothing else tells it: red and blue in green's place make a chequered green."""
    subject = subject_of(smooth())
    mosaic = np.take_along_axis(subject.truth, subject.channel_index[..., None].astype(int), axis=2)[..., 0]
    mosaic = mosaic * NEUTRAL.astype(np.float32)[subject.channel_index]
    for phase, said in (("RGGB", None), ("GRBG", "it was demosaiced as GRBG, and the mosaic is RGGB")):
        planes = demosaic(mosaic, Cfa.bayer(phase).channel_index(ROWS, COLS), 3)
        fault = order_fault(np.moveaxis(planes, 0, 2) / NEUTRAL.astype(np.float32), subject)
        assert (fault and fault.sentence) == said


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


def test_an_edge_tells_a_shift_across_it_and_none_along(rng):
    y, x = np.indices((SIDE, SIDE))
    across = math.cos(0.1), math.sin(0.1)

    def edge(moved_x, moved_y):
        return 0.4 + 0.3 * np.tanh((x - SIDE / 2 - moved_x) * across[0] + (y - SIDE / 2 - moved_y) * across[1])

    subject = subject_of(edge(0.0, 0.0))
    found = subject_of(edge(0.3, -0.5)).truth + rng.normal(0.0, 0.02, (SIDE, SIDE, 3)).astype(np.float32)
    stated = np.array(best_shift(found, subject))
    assert stated @ across == pytest.approx(0.3 * across[0] - 0.5 * across[1], abs=0.035)
    assert abs(stated @ (-across[1], across[0])) < 0.01
