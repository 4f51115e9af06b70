"""Light of one's own on a sensor: what goes in is what the codes say, and the noise has the laws of its stages."""

import numpy as np
import pytest
import scipy.special

import camsim
from camsim.core.kernels.counts import fill_counts
from camsim.errors import InvalidValueError
from camsim.spectra.rgb import reflectance_of_rgb

MONO = camsim.Sensor.from_yaml("mono-345")
BAYER = camsim.Sensor.from_yaml("d40-like")
ON_SENSOR = camsim.Light("D65", illuminance_lux=10.0, at="sensor")
HOW = camsim.Exposure(time_s=0.02, iso=200)
CROSSTALK = camsim.Crosstalk(((0, 0.01, 0), (0.03, 0.9, 0.02), (0, 0.04, 0)))


def ramp(rows, cols, most=9000.0):
    return np.linspace(0.0, most, rows * cols).reshape(rows, cols)


@pytest.mark.parametrize("sensor", [MONO, BAYER, BAYER.replace(full_well=None)])
@pytest.mark.parametrize("iso", [200, 1600])
def test_without_noise_the_codes_are_the_electrons_over_the_gain(sensor, iso):
    electrons = ramp(37, 50)
    frame = sensor.expose(electrons, unit="electrons", exposure=camsim.Exposure(time_s=1.0, iso=iso), noise=False)
    per_dn = sensor.adc.electrons_per_dn * sensor.adc.base_iso / iso
    assert np.array_equal(frame.mosaic, np.clip(np.rint(electrons / per_dn + sensor.adc.black_level_dn), 0, 4095))
    assert np.array_equal(frame.mean_electrons, electrons)


def test_planes_of_the_channels_are_sampled_and_are_the_truth():
    planes = np.random.default_rng(2).uniform(0.0, 9000.0, (12, 16, 3))
    frame = BAYER.expose(planes, unit="electrons", noise=False)
    np.testing.assert_allclose(frame.truth, planes, rtol=1e-6)
    for row, col, channel in ((0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 2)):
        assert np.array_equal(frame.mean_electrons[row::2, col::2], planes[row::2, col::2, channel])


@pytest.mark.parametrize("colour", [(0.5, 0.5, 0.5), (0.8, 0.1, 0.05), (0.1, 0.3, 0.9)])
@pytest.mark.parametrize("crosstalk", [None, CROSSTALK])
def test_it_is_the_even_scene_of_that_colour_to_the_code(colour, crosstalk):
    how = {"light": ON_SENSOR, "exposure": HOW, "seed": 5, "region": camsim.Region(rows=8, cols=10)}
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=4.0)).replace(crosstalk=crosstalk)
    scene = camera.expose(camsim.Scene(background=reflectance_of_rgb(colour)), products=("truth",), **how)
    given = np.broadcast_to(np.array(colour), (8, 10, 3))
    light = BAYER.replace(crosstalk=crosstalk).expose(given, unit="reflectance", **how)
    np.testing.assert_allclose(light.mean_electrons, scene.mean_electrons, rtol=1e-9)
    np.testing.assert_allclose(light.truth, scene.truth, rtol=1e-6)
    assert np.array_equal(light.mosaic, scene.mosaic)
    assert light.cfa_pattern == scene.cfa_pattern


def test_a_cube_of_a_flat_reflectance_is_grey_and_more_than_white_is_light():
    grey = BAYER.expose(np.full((6, 8), 2.5), unit="reflectance", exposure=HOW)
    cube = BAYER.expose(
        np.full((6, 8, 31), 2.5), unit="reflectance", exposure=HOW, wavelength_nm=np.arange(400, 701, 10)
    )
    np.testing.assert_allclose(cube.mean_electrons, grey.mean_electrons, rtol=1e-9)
    white = BAYER.expose(np.ones((6, 8)), unit="reflectance", exposure=HOW)
    np.testing.assert_allclose(grey.mean_electrons, 2.5 * white.mean_electrons, rtol=1e-12)


def test_an_irradiance_is_the_light_that_has_it():
    nodes_nm = np.arange(400.0, 701.0, 20.0)
    stated = np.linspace(1.0, 3.0, nodes_nm.size)
    light = camsim.Light(camsim.Curve(nodes_nm, stated), irradiance_w_per_m2=2e-3, at="sensor")
    level = light.irradiance_at(nodes_nm)
    by_light = BAYER.expose(np.ones((4, 4)), unit="reflectance", light=light, exposure=HOW)
    by_bands = BAYER.expose(
        np.broadcast_to(level, (4, 4, level.size)), unit="irradiance", wavelength_nm=nodes_nm, exposure=HOW
    )
    np.testing.assert_allclose(by_bands.mean_electrons, by_light.mean_electrons, rtol=1e-6)


def test_photons_give_as_many_electrons_as_the_efficiency_says():
    flat = camsim.QuantumEfficiency((("Y", camsim.Curve((400.0, 700.0), (0.6, 0.6))),), per="photon", peak=0.6)
    sensor = MONO.replace(quantum_efficiency=flat, filters=(0.5,))
    frame = sensor.expose(np.full((3, 5), 1000.0), unit="photons", wavelength_nm=[550.0], exposure=HOW)
    np.testing.assert_allclose(frame.mean_electrons, 300.0, rtol=1e-12)
    with pytest.raises(InvalidValueError, match="extend the table"):
        sensor.expose(np.ones((3, 5)), unit="photons", wavelength_nm=[900.0])


@pytest.mark.parametrize(("unit", "counts"), [("electrons", 9), ("reflectance", 1)])
def test_finer_light_is_added_up_on_the_photosites(unit, counts):
    small = camsim.Sensor.from_yaml("mono-345", overrides=["sensor.frame.rows=6", "sensor.frame.cols=8"])
    fine = np.random.default_rng(4).uniform(0.0, 1.0, (18, 24))
    coarse = np.array([[fine[3 * r : 3 * r + 3, 3 * c : 3 * c + 3].mean() for c in range(8)] for r in range(6)])
    by_itself = small.expose(fine, unit=unit, exposure=HOW).mean_electrons
    np.testing.assert_allclose(by_itself, small.expose(counts * coarse, unit=unit, exposure=HOW).mean_electrons)
    said = MONO.expose(fine, unit=unit, exposure=HOW, per_photosite=3).mean_electrons
    np.testing.assert_allclose(said, by_itself)


@pytest.mark.parametrize("pattern", ["bayer", "x-trans"])
@pytest.mark.parametrize("sampled", [True, False])
def test_crosstalk_goes_on_beyond_the_border_as_within(pattern, sampled):
    cfa = camsim.Cfa.bayer("RGGB") if pattern == "bayer" else camsim.Cfa.named("x-trans")
    sensor = BAYER.replace(crosstalk=CROSSTALK, cfa=cfa)
    planes = np.broadcast_to(np.array([100.0, 700.0, 300.0]), (24, 24, 3))
    mosaic = np.take_along_axis(planes, cfa.channel_index(24, 24)[..., None].astype(int), axis=2)[..., 0]
    frame = sensor.expose(mosaic if sampled else planes, unit="electrons", noise=False)
    rows, cols = cfa.period
    np.testing.assert_allclose(frame.mean_electrons[:rows, :cols], frame.mean_electrons[12:][:rows, 12 : 12 + cols])
    np.testing.assert_allclose(frame.mean_electrons[-rows:, -cols:], frame.mean_electrons[12:][:rows, 12 : 12 + cols])


def test_srgb_is_decoded_and_whole_numbers_are_fractions_of_their_largest():
    codes = np.array([[[0, 128, 255], [64, 200, 30]]], np.uint8)
    linear = np.where(codes / 255 <= 0.04045, codes / 255 / 12.92, ((codes / 255 + 0.055) / 1.055) ** 2.4)
    by_codes = BAYER.expose(codes, unit="srgb", exposure=HOW, noise=False)
    by_light = BAYER.expose(linear, unit="reflectance", exposure=HOW, noise=False)
    np.testing.assert_allclose(by_codes.mean_electrons, by_light.mean_electrons)
    half = BAYER.expose(np.full((2, 2), 32768, np.uint16), unit="reflectance", exposure=HOW, noise=False)
    white = BAYER.expose(np.ones((2, 2)), unit="reflectance", exposure=HOW, noise=False)
    np.testing.assert_allclose(half.mean_electrons / white.mean_electrons, 32768 / 65535)


def test_colours_outside_srgb_are_said():
    given = np.full((4, 4, 3), (-0.9, 0.1, 0.1))
    frame = BAYER.expose(given, unit="reflectance", exposure=HOW)
    assert frame.mean_electrons.min() == 0.0
    assert any(note.text.startswith("4 photosites would get less light than none") for note in frame.report.notes)


def test_codes_of_a_picture_taken_as_reflectances_are_said():
    codes = np.random.default_rng(1).integers(0, 256, (8, 9, 3)).astype(np.uint8)
    for given, said in ((codes, True), (codes / 255, True), (codes.astype(np.float32) / 254.3, False)):
        notes = BAYER.expose(given, unit="reflectance", exposure=HOW).report.notes
        assert any(note.code == "codes-as-light" for note in notes) == said


class Tensor:
    """As tensors on the CPU are: no array, and gives one of the same memory."""

    def __init__(self, array):
        self._array = array

    def numpy(self):
        return self._array


def test_noise_in_a_loop_is_that_of_an_exposure():
    noise = camsim.Noise(MONO, iso=100)
    electrons = ramp(128, 128, 8000.0)
    exposure = camsim.Exposure(time_s=0.01, iso=100)
    for seed in range(3):
        frame = MONO.expose(electrons, unit="electrons", seed=seed, exposure=exposure)
        assert np.array_equal(noise(electrons, seed), frame.electrons.astype(np.float32))


@pytest.mark.parametrize("mean", [0.01, 0.7, 3.99, 4.01, 9.99, 35.0, 900.0, 2e5])
def test_a_count_has_the_cumulative_probability_of_its_normal_number(mean):
    normals = np.append(np.random.default_rng(5).standard_normal(200_000), np.linspace(-6.0, 6.0, 2000))
    counts = np.empty_like(normals)
    fill_counts(counts, np.full_like(normals, mean), normals)
    upper = normals > 0.0  # of each, the smaller tail keeps the digits
    short = np.where(upper, scipy.special.pdtrc(counts, mean), scipy.special.ndtr(normals))
    reached = np.where(upper, scipy.special.ndtr(-normals), scipy.special.pdtr(counts, mean))
    assert (short - reached < 1e-13).all()
    one_less = np.where(upper, scipy.special.pdtrc(counts - 1.0, mean), scipy.special.pdtr(counts - 1.0, mean))
    passed = np.where(upper, one_less - reached, short - one_less)
    assert (passed[counts > 0.0] > -1e-13).all()


def test_noise_of_several_images_and_of_tensors():
    noise = camsim.Noise(BAYER, iso=800)
    images = np.full((2, 3, 16, 16), 50.0, np.float32)
    noisy = noise(Tensor(images), 3)
    assert (noisy.shape, noisy.dtype) == (images.shape, np.float32)
    assert np.array_equal(noisy, noise(images, 3))
    assert len({image.tobytes() for image in noisy.reshape(6, 16, 16)}) == 6
    assert (images == 50.0).all()
    with pytest.raises(InvalidValueError, match="finite, and 0 or more"):
        noise(-images, 3)
