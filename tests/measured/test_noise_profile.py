"""What stands beside measured noise as the profile's own: flats and darks of a few photosites must agree with it."""

import dataclasses
import math

import pytest
from tolerances import STATISTICAL

import camsim
from camsim.api import load_camera
from camsim.measure.noise import expected_of, measure_noise, take_shots
from tests.tables import rows

BENT = camsim.PolynomialResponse((-0.2,), scale_e=40_000.0)
LOPSIDED = camsim.Crosstalk(((0, 0, 0), (0, 0.6, 0.35), (0, 0, 0)))

SMALL_WELL, HOT = camsim.DualGain(from_iso=100.0, capacity_e=4000.0), camsim.DarkCurrent(1e6)


def camera_of(sensor, *, offsets=((0,),), **changes):
    camera = load_camera(sensor, lens=camsim.Airy(f_number=8.0))
    return camera.replace(adc=dataclasses.replace(camera.adc, black_offsets_dn=offsets), **changes)


@pytest.mark.parametrize(("figure", "sensor", "iso", "changes"), rows("wells.txt", "profiles"))
def test_flats_and_darks_agree_with_the_profile(figure, sensor, iso, changes):
    """Linearity was that of the well's own levels at any ISO, DSNU that of all channels' black offsets together.

    A full well was beside its light alone, the dark's part of it left out.
    """
    iso = eval(iso)
    camera = camera_of(sensor, **eval(changes))
    for channel in measure_noise(take_shots(camera, side=48, frames=4, iso=iso)).channels:
        stated, found = expected_of(camera, channel.channel, iso=iso)[figure], channel.figures()[figure]
        if math.isfinite(found.at_most):
            assert stated < found.at_most, channel.channel
        else:
            assert abs(found.value - stated) < STATISTICAL * found.sigma, channel.channel


@pytest.mark.parametrize(
    ("iso", "dual_gain", "by_hand"),
    [(200.0, None, 0.0309584), (3200.0, None, 0.0017618), (200.0, 4000.0, 0.0028170)],
)
def test_linearity_by_hand(iso, dual_gain, by_hand):
    """An auditor's sums: the root of r(e) = saturation, twelve levels of it, and the line of least relative errors."""
    dual = None if dual_gain is None else camsim.DualGain(from_iso=100.0, capacity_e=dual_gain)
    camera = camera_of("d40-like", nonlinearity=BENT, dual_gain=dual, dark_current=None)
    assert expected_of(camera, "G1", iso=iso)["linearity_error"] == pytest.approx(by_hand, rel=1e-4)


def test_a_blind_channel_has_no_flats():
    stated = expected_of(camera_of("d40-like", filters=(0.0,), nonlinearity=BENT), "B")
    assert math.isnan(stated["prnu"])
    assert math.isnan(stated["linearity_error"])
    assert stated["gain_dn_per_e"] == pytest.approx(0.1)


def test_greens_of_a_lopsided_crosstalk_are_told_apart():
    camera = camera_of("d40-like", crosstalk=LOPSIDED, prnu=camsim.Prnu(0.05))
    one, other, both = (expected_of(camera, name)["prnu"] for name in ("G1", "G2", "G"))
    assert abs(one - other) > 0.001
    assert both > max(one, other)  # the greens' own difference is a pattern where they are taken together
