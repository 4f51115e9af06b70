"""What a scene does not need is left out, and proved so: counters fall, and the image stays the same."""

import dataclasses

import numpy as np
import pytest
from examples import OPTICS, PICTURE, TOLERANCE, WAVELENGTH_NM, grid_of, moved, scene_of, worst
from tolerances import METHOD, ROUNDING

import camsim
from camsim.camera.capture import Capture
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels

# Ten pitches wide, far outside a window of twenty.
OUTSIDE = (np.array([(-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)]) + np.array([2000.0, 300.0]), 0.9)
GAUSSIAN = [camsim.Gaussian(sigma_um=3.0), camsim.SquarePhotosite(side_um=4.0)]

CAPTURE = Capture(
    camera=camsim.Camera(
        rows=64,
        cols=64,
        pitch_um=4.0,
        lens=camsim.Airy(f_number=5.6),
        olpf=camsim.FourSpotOlpf(split_um=3.0),
        photosite=camsim.SquarePhotosite(side_um=4.0),
        cfa=camsim.Cfa.bayer("RGGB"),
        quantum_efficiency=camsim.QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.4),
        read_noise=camsim.ReadNoise(sigma_e=4.0),
        adc=camsim.Adc(bit_depth=12, black_level_dn=64, electrons_per_dn=5.0, base_iso=100.0),
    ),
    scene=scene_of(PICTURE),
    light=camsim.Light("D55", illuminance_lux=3000.0),
    exposure=camsim.Exposure(time_s=0.02, iso=100.0),
    tolerance=1e-4,
)


def work_of(capture, products=("mosaic",)):
    return capture.frame(products=products).report.work


def with_camera(**changes):
    return dataclasses.replace(CAPTURE, camera=CAPTURE.camera.replace(**changes))


def with_shapes(*shapes):
    return dataclasses.replace(CAPTURE, scene=scene_of(list(shapes)))


def in_light(**light):
    return dataclasses.replace(CAPTURE, light=camsim.Light(illuminance_lux=3000.0, **light))


SAME_BACKGROUND = [*PICTURE[:2], (PICTURE[2][0], 0.3)]
MONO = {
    "cfa": camsim.Cfa.mono(),
    "quantum_efficiency": camsim.QuantumEfficiency(
        (("Y", camsim.Curve((400.0, 700.0), (0.4, 0.4), outside="zero")),), per="photon", peak=0.4
    ),
}

# What is there, what is not, the counter that falls, and to what share of its value at the most (0: to nothing).
PAIRS = {
    "OLPF": (CAPTURE, with_camera(olpf=None), "table_terms", 0.95),
    "noise": (CAPTURE, dataclasses.replace(CAPTURE, noise=False), "random_numbers", 0.0),
    "one stage of noise": (CAPTURE, with_camera(read_noise=None), "random_numbers", 0.5),
    "a window": (CAPTURE, dataclasses.replace(CAPTURE, region=camsim.Region(rows=32, cols=16)), "photosites", 0.125),
    "two channels": (CAPTURE, with_camera(**MONO), "table_values", 0.6),
    "a shape": (CAPTURE, with_shapes(*PICTURE[:2]), "edges", 0.999),
    "edges of equal spectra: one surface of two": (CAPTURE, with_shapes(*SAME_BACKGROUND), "edges", 0.999),
    "all shapes": (CAPTURE, with_shapes(), "nodes_integrated", 0.0),
    "wavelengths: a line": (CAPTURE, in_light(line_nm=550.0), "wavelength_nodes", 0.1),
    "wavelengths: a narrow band": (CAPTURE, in_light(line_nm=550.0, width_nm=2.0), "wavelengths", 0.2),
}


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_a_scene_that_lacks_one_thing_takes_less(pair):
    whole, less, counter, share = pair
    before, after = work_of(whole)[counter], work_of(less).get(counter, 0)
    assert before > 0
    assert after <= share * before


def test_the_truth_is_what_needs_every_channel():
    with_truth, without = work_of(CAPTURE, ("mosaic", "truth")), work_of(CAPTURE)
    assert without["channels"] == 1
    assert with_truth["channels"] == 3
    assert with_truth["photosites"] == 3 * without["photosites"]


def test_a_shape_outside_the_window_is_not_rendered():
    picture = [*PICTURE, OUTSIDE]
    rendering = camsim.render(
        scene_of(picture), GAUSSIAN, grid_of(20, 20), wavelength_nm=WAVELENGTH_NM, tolerance=TOLERANCE
    )
    alone = camsim.render(
        scene_of(PICTURE), GAUSSIAN, grid_of(20, 20), wavelength_nm=WAVELENGTH_NM, tolerance=TOLERANCE
    )
    assert rendering.work.edges_far == 4
    assert rendering.work.edges == alone.work.edges
    np.testing.assert_array_equal(rendering.image, alone.image)


def rendered(shapes, optics, *, prune, tolerance=TOLERANCE, method="auto"):
    return camsim.render(
        scene_of(shapes),
        optics,
        grid_of(20, 20),
        wavelength_nm=WAVELENGTH_NM,
        tolerance=tolerance,
        method=method,
        prune=prune,
    )


@pytest.mark.parametrize("optics", [*OPTICS.values(), GAUSSIAN], ids=[*OPTICS, "Gaussian"])
@pytest.mark.parametrize("method", ["boundary", "fourier"])
def test_without_pruning_nothing_changes_where_nothing_was_dropped_by_its_bound(optics, method):
    pruned, whole = (rendered(PICTURE, optics, prune=prune, method=method) for prune in (True, False))
    assert pruned.work.edges_far == 0
    assert worst(pruned.image, whole.image) <= ROUNDING


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5])
def test_what_is_dropped_by_its_bound_is_a_tenth_of_the_tolerance(tolerance):
    """Squares all round, from near to far: those dropped are computed by prune=False and found to be as small."""
    around = [
        moved([OUTSIDE], shift=(-2000.0 + r * np.cos(a), -300.0 + r * np.sin(a)))[0]
        for r in (40.0, 200.0, 1000.0, 5000.0, 3e4, 3e5)
        for a in (0.3, 1.9, 4.1)
    ]
    pruned, whole = (rendered([*PICTURE, *around], OPTICS["f/8"], prune=p, tolerance=tolerance) for p in (True, False))
    assert 0 < pruned.work.edges_far < 72
    assert pruned.work.edges + pruned.work.edges_far == whole.work.edges
    assert worst(pruned.image, whole.image) <= 0.1 * tolerance


def test_edges_that_no_channel_sees_are_dropped_and_weigh_nothing():
    """Two reds that differ in the infrared only, side by side: the light has none."""
    nm = np.array([450.0, 550.0, 650.0])
    one = camsim.Curve((400.0, 700.0, 701.0, 800.0), (0.2, 0.8, 0.1, 0.1))
    two = camsim.Curve((400.0, 700.0, 701.0, 800.0), (0.2, 0.8, 0.9, 0.9))
    left = np.array([(-6.0, -5.0), (0.5, -5.0), (-0.5, 5.0), (-6.0, 5.0)])
    right = np.array([(0.5, -5.0), (6.0, -5.0), (6.0, 5.0), (-0.5, 5.0)])
    how = {
        "system": OpticalSystem.of(OPTICS["f/8, OLPF"]),
        "grid": grid_of(12, 14),
        "response": np.ones((1, 3)),
        "wavelength_nm": nm,
        "channel": np.zeros((12, 14), np.uint8),
        "tolerance": TOLERANCE,
    }
    pruned, whole = (
        render_channels(scene_of([(left, one), (right, two)], 0.0), prune=prune, **how) for prune in (True, False)
    )
    assert pruned.work.edges_equal == 1
    assert whole.work.edges == pruned.work.edges + 1
    assert worst(pruned.image, whole.image) <= ROUNDING * 3
    joined = render_channels(scene_of([(left, one), (right, one)], 0.0), **how)
    assert worst(pruned.image, joined.image) <= METHOD * TOLERANCE * 3
