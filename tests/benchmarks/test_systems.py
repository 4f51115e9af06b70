"""What the bench renders is what it says."""

import math

import numpy as np
import pytest
import shapely

from bench.paper import cases
from bench.paper.peers import PEERS, Peer, installed_peers
from camsim.errors import UnknownNameError, UnsupportedError
from camsim.scene import flattened


def test_every_system_of_the_issue_is_there():
    assert len(cases.PSFS) == 7 + 3 * 8 + 1
    assert cases.PSFS["gaussian-0.25"].stages()[0].otf(np.array(0.25 / cases.PITCH_UM), np.array(0.0), 550.0) == (
        pytest.approx(0.5)
    )
    assert cases.PSFS["airy-f8-box-olpf"].split_px == 0.75
    wavelength_nm, weights = cases.PSFS["bayer-green"].spectrum()
    assert weights.sum() == pytest.approx(1.0)
    assert 520 < weights @ wavelength_nm < 560


def test_the_window_lies_around_one_edge_and_its_end():
    distance = cases.edge_distance_px()
    assert distance.size <= 4000
    assert -35 < distance.min() < -29
    assert 29 < distance.max() < 35
    x0, y0 = cases.window().first_centre
    corner = cases.corners_px()[0]
    assert x0 < corner[0] < x0 + cases.WINDOW_COLS
    assert y0 < corner[1] < y0 + cases.WINDOW_ROWS
    # The distance is the one to the square's left side, by geometry.
    side = shapely.LineString([cases.corners_px()[0], cases.corners_px()[3]])
    apart = side.distance(shapely.Point(x0 + 40, y0 + 30))
    assert abs(distance[30, 40]) == pytest.approx(apart, abs=1e-9)


def test_the_scene_is_the_square():
    [square] = flattened(cases.square((0.3, -0.2)).shapes)
    outline = square.layers[0][0].curves.points[:, 0] / cases.PITCH_UM
    np.testing.assert_allclose(
        np.sort(outline, axis=0), np.sort(cases.corners_px() + np.array([0.3, -0.2]), axis=0), atol=1e-9
    )


def test_25_shifts_fill_a_pixel_along_the_normal_and_hold_the_middle():
    shifts = cases.shifts_px(25)
    along = shifts @ [math.cos(math.radians(4)), math.sin(math.radians(4))]
    np.testing.assert_allclose(np.diff(along), 1 / 25, atol=1e-12)
    for count in (1, 3, 5, 25):
        np.testing.assert_allclose(cases.shifts_px(count)[count // 2], 0.0, atol=1e-12)


def test_methods_meet_the_systems_that_they_can_draw():
    green = {s.method for s in cases.settings_of(cases.PSFS["bayer-green"], cases.METHODS)}
    assert green == {"auto", "boundary", "fourier"}
    airy = cases.settings_of(cases.PSFS["airy-f8"], cases.METHODS)
    assert {s.samples for s in airy if s.method == "importance"} == {121, 2025, 40401}
    assert "strips" not in {s.method for s in airy}
    boxed = cases.settings_of(cases.PSFS["airy-f8-box"], cases.METHODS)
    assert 40401 not in {s.samples for s in boxed}
    tolerances = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 3e-7, 1e-7, 1e-8]
    assert [s.tolerance for s in boxed if s.method == "auto"] == pytest.approx(tolerances)
    assert [s.label for s in boxed if s.method == "auto"][4:7] == ["auto 1e-6", "auto 3e-7", "auto 1e-7"]
    assert "strips" in {s.method for s in cases.settings_of(cases.PSFS["gaussian-0.40"], cases.METHODS)}


def test_names_and_patterns():
    assert [p.name for p in cases.chosen_psfs(["airy-f8*"])] == ["airy-f8", "airy-f8-box", "airy-f8-box-olpf"]
    with pytest.raises(UnknownNameError, match=r"unknown psf 'airy-f9'; did you mean 'airy-f8'.*'airy-f8\*'"):
        cases.chosen_psfs(["airy-f9"])
    with pytest.raises(UnknownNameError, match="did you mean 'boundary'"):
        cases.chosen_methods(["bondary"])


def test_no_peer_installed_says_which_and_how(monkeypatch):
    monkeypatch.setattr("bench.paper.peers.find_spec", lambda name: None)
    with pytest.raises(UnsupportedError, match=r"none of galsim, prysm is installed; .*pip install .*\[bench\]"):
        installed_peers()
    assert all(isinstance(peer, Peer) for peer in PEERS.values())
