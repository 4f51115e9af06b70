"""The error estimate tells the truth: whatever is corrupted, an error of ten tolerances does not stay below one."""

import dataclasses

import numpy as np
import pytest
from examples import OPTICS, PICTURE, PITCH_UM, TOLERANCE, WAVELENGTH_NM, grid_of, scene_of, worst

import camsim
from camsim.rendering import by_boundary, engine, footprint, spotcheck

# Short waves on a wide footprint: there the far form begins where the footprint's moments still matter.
WIDE = [
    camsim.Airy(f_number=2.8),
    camsim.FourSpotOlpf(split_um=1.5 * PITCH_UM),
    camsim.SquarePhotosite(side_um=PITCH_UM),
]
SYSTEMS = {name: OPTICS[name] for name in ("f/1.4, fill factor 0.5", "f/8", "f/8, OLPF")}


@pytest.fixture(params=SYSTEMS.values(), ids=SYSTEMS)
def optics(request):
    return request.param


def rendered(optics, tolerance=TOLERANCE, rows=40, cols=40):
    return camsim.render(
        scene_of(PICTURE),
        optics,
        grid_of(rows, cols),
        wavelength_nm=WAVELENGTH_NM,
        method="boundary",  # whose parts are corrupted here
        tolerance=tolerance,
    )


def scaled(function, factor):
    return lambda *args, **kwargs: factor * function(*args, **kwargs)


def changed(function, **factors):
    """The function with some numbers of what it returns multiplied."""

    def wrong(*args, **kwargs):
        right = function(*args, **kwargs)
        return dataclasses.replace(right, **{name: getattr(right, name) * f for name, f in factors.items()})

    return wrong


def assert_seen(monkeypatch, corrupt, optics, size=40):
    honest = rendered(optics, rows=size, cols=size)
    with monkeypatch.context() as patch:
        corrupt(patch)
        corrupted = rendered(optics, rows=size, cols=size)
    assert honest.error_estimate <= TOLERANCE
    assert worst(corrupted.image, honest.image) > 10 * TOLERANCE  # or the test says nothing
    assert corrupted.error_estimate > TOLERANCE


@pytest.mark.parametrize("factor", [1 + 1e-3, 1 - 1e-3])
def test_a_wrong_field(monkeypatch, optics, factor):
    field = scaled(engine.field_tables, factor)
    assert_seen(monkeypatch, lambda patch: patch.setattr(engine, "field_tables", field), optics)


@pytest.mark.parametrize("factor", [1 + 1e-3, 1 - 1e-3])
def test_a_wrong_edge_response(monkeypatch, factor):
    response = scaled(engine.edge_responses, factor)
    for optics in (OPTICS["f/1.4, fill factor 0.5"], OPTICS["f/8, OLPF"], WIDE):
        assert_seen(monkeypatch, lambda patch: patch.setattr(engine, "edge_responses", response), optics)


@pytest.mark.parametrize("factor", [1 + 1e-3, 1 - 1e-3])
def test_wrong_far_moments(monkeypatch, optics, factor):
    moments = scaled(engine.far_moments, factor)
    assert_seen(monkeypatch, lambda patch: patch.setattr(engine, "far_moments", moments), optics)


def test_far_moments_that_are_wrong_wherever_they_are_used(monkeypatch, optics):
    """The check has the same moments, but from another radius on: c1 off by a twentieth does not cancel."""
    moments = scaled(engine.far_moments, np.array([1.0, 1.05, 1.0, 1.0]))

    def corrupt(patch):
        patch.setattr(engine, "far_moments", moments)
        patch.setattr(spotcheck, "far_moments", moments)

    assert_seen(monkeypatch, corrupt, optics)


@pytest.mark.parametrize(("moment", "factor"), [("sigma2", 1.5), ("m4", 1.5), ("m22", 20.0)])
def test_wrong_moments_of_the_footprint(monkeypatch, moment, factor):
    wrong = changed(footprint.Footprint.of, **{moment: factor})
    assert_seen(monkeypatch, lambda patch: patch.setattr(footprint.Footprint, "of", wrong), WIDE)


@pytest.mark.parametrize(
    "factors",
    [
        {"near": 0.3, "reach": 0.3, "quiet_end": 0.3, "quiet_line": 0.3},
        {"field_step": 8.0},
        {"response_step": 8.0},
        {"panel": 5.0},
    ],
    ids=lambda factors: " and ".join(factors),
)
def test_careless_settings(monkeypatch, factors):
    plan = changed(by_boundary.plan_boundary, **factors)
    assert_seen(monkeypatch, lambda patch: patch.setattr(by_boundary, "plan_boundary", plan), WIDE)


@pytest.mark.parametrize("size", [40, 100, 150])
def test_tiles_interpolated_too_coarsely(monkeypatch, optics, size):
    true_plan = by_boundary.plan_boundary

    def coarse(*args, **kwargs):
        return dataclasses.replace(true_plan(*args, **kwargs), tile_nodes=3)

    assert_seen(monkeypatch, lambda patch: patch.setattr(by_boundary, "plan_boundary", coarse), optics, size)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6, 1e-7])
def test_an_honest_rendering_is_within_its_tolerance(optics, tolerance):
    rendering = rendered(optics, tolerance, rows=24, cols=24)
    assert rendering.error_estimate <= tolerance
    assert rendering.checked_photosites >= 4


def test_a_scene_without_edges_has_no_error():
    flat = camsim.render(camsim.Scene(background=0.4), OPTICS["f/8"], grid_of(3, 3), wavelength_nm=WAVELENGTH_NM)
    assert worst(flat.image, 0.4) == 0.0
    assert flat.error_estimate == 0.0


def test_the_estimate_is_the_same_every_time(optics):
    assert rendered(optics).error_estimate == rendered(optics).error_estimate


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (1, 3), (2, 2)])
def test_of_a_tiny_frame_every_photosite_is_checked(rows, cols):
    """Then the estimate is the largest error, to a tenth of the tolerance; the truth is a far finer rendering."""
    coarse = rendered(OPTICS["f/8, OLPF"], 1e-2, rows, cols)
    fine = rendered(OPTICS["f/8, OLPF"], 1e-7, rows, cols)
    assert coarse.checked_photosites == rows * cols
    assert coarse.error_estimate == pytest.approx(worst(coarse.image, fine.image), abs=1e-2 / 10)
