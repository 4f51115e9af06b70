"""Moiré of a zone plate falls by what the low-pass filter's transfer says, in mono and in the channels of a mosaic."""

import math

import numpy as np
import pytest

import camsim
from camsim.errors import UnsupportedError
from camsim.measure import picture_of_frame
from camsim.measure.target import measure_moire


def measured(step, olpf):
    """Rings with 1.25 line pairs per sample at the rim, in green light; step 2: the channels of a Bayer array."""
    rim, (sensor, pitch_um) = 60 * step, ("d40-like", 4.88) if step == 2 else ("mono-345", 3.45)
    plate = f"{{kind: chart, name: zone-plate, radius: {rim}, rim_period: {step / 1.25}, dark: 0.1}}"
    side, split = 2 * rim + 8, f"sensor.olpf={{kind: four-spot, split_um: {0.3 * step * pitch_um}}}"
    changes = [
        f"region={{rows: {side}, cols: {side + 12}}}",
        f"scene.shapes=[{plate}]",
        "noise.enabled=false",
        "render.tolerance=5e-3",
    ]
    changes += ["light={line_nm: 550, illuminance_lux: 2000}", split if olpf else "sensor.olpf=null"]
    # A photosite as wide as the pitch would leave nothing at the sampling frequency.
    changes += ["sensor.photosite={kind: square, fill_factor: 0.49}"]
    capture = camsim.load("zone-plate", sensor=sensor, overrides=changes)
    return measure_moire(picture_of_frame(capture.frame(), "electrons"), capture), capture


@pytest.mark.parametrize("step", [1, 2])
def test_it_falls_by_what_theory_gives(step):
    (without, capture), (filtered, with_olpf) = measured(step, olpf=False), measured(step, olpf=True)
    assert len(without.ghosts) == len(filtered.ghosts) == (4 if step == 1 else 16)
    pitch_um = capture.camera.pitch_um
    split_um = with_olpf.camera.olpf.split_um
    # Spots at ±d/2 along an axis: |cos(π·d·f)| of what comes along it.
    falls = abs(math.cos(math.pi * split_um / pitch_um / step))
    for channel in {ghost.channel for ghost in without.ghosts}:
        assert filtered.moire(channel) / without.moire(channel) == pytest.approx(falls, rel=0.01)
    for ghost in (*without.ghosts, *filtered.ghosts):
        assert ghost.contrast == pytest.approx(ghost.theory, abs=0.003)
        assert np.hypot(ghost.x_pixel, ghost.y_pixel) == pytest.approx(60 * step / 1.25, rel=1e-9)


@pytest.mark.parametrize(
    ("olpf", "f_number", "split"), [("four-spot", 2.8, 0.9), ("two-spot", 4.0, 0.6)], ids=["four", "two"]
)
def test_a_ghost_has_the_contrast_of_its_middle(olpf, f_number, split):
    """Airy, cosine and sinc by hand: what an OLPF takes beside the middle must not count, nor hide in the error."""
    changes = [
        "light={line_nm: 550, illuminance_lux: 2000}",
        "sensor.photosite={kind: rectangular, width_um: 2.0, height_um: 1.2}",
        f"sensor.olpf={{kind: {olpf}, split_pitches: {split}}}",
        f"lens.f_number={f_number}",
        "region={rows: 160, cols: 160}",
        "scene.shapes=[{kind: chart, name: zone-plate, radius: 76, rim_period: 0.72, dark: 0.1}]",
        "render.tolerance=1e-3",
    ]
    nu = 0.55 * f_number / 3.45
    lens = 2.0 / math.pi * (math.acos(nu) - nu * math.sqrt(1.0 - nu * nu))
    capture = camsim.load("zone-plate", sensor="mono-345", overrides=changes)
    frame = capture.frame()
    for product in ("mean_electrons", "mosaic"):
        for ghost in measure_moire(picture_of_frame(frame, product), capture).ghosts:
            lies_along_x = ghost.fx_cycles_per_pixel != 0.0
            one = lens * np.sinc((2.0 if lies_along_x else 1.2) / 3.45)
            one *= abs(math.cos(math.pi * split)) if lies_along_x or olpf == "four-spot" else 1.0
            assert abs(ghost.contrast - one) < 3.0 * ghost.contrast_error + 5e-4
            assert ghost.contrast_error < 0.02
            if product == "mean_electrons":
                assert ghost.contrast == pytest.approx(one, abs=0.0025)


def test_a_plate_that_shows_no_ghost_says_what_would():
    """In green, every other photosite of a Bayer array: 56 px are too few, and beside the range of rims none fits."""
    for shape, says in (
        ("radius: 56, rim_period: 0.833333", "2.4 line pairs per sample of R at a rim of 56 px: too small .* 68 px"),
        ("radius: 80, rim_period: 1", "2 line pairs .* from 1.2 to 1.42, where"),
    ):
        plate = f"scene.shapes=[{{kind: chart, name: zone-plate, {shape}}}]"
        changes = ["region={rows: 24, cols: 24}", "render.tolerance=1e-2", plate]
        capture = camsim.load("zone-plate", sensor="d40-like", overrides=changes)
        with pytest.raises(UnsupportedError, match=says):
            measure_moire(picture_of_frame(capture.frame()), capture)


def test_a_scene_without_a_plate_is_refused():
    capture = camsim.load("zone-plate", overrides=["region={rows: 32, cols: 32}", "scene.shapes=[]"])
    with pytest.raises(UnsupportedError, match="no chart zone-plate"):
        measure_moire(picture_of_frame(capture.frame()), capture)
