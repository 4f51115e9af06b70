"""Figures of whole captures: radiometry, noise, files and targets."""

import csv
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from tolerances import STATISTICAL

import camsim
from camsim.errors import InvalidValueError
from camsim.files.dng import noise_profile
from camsim.sensor.stage import gains

PROJECT = Path(__file__).parents[2]
LENS = camsim.Airy(f_number=8.0)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=100)


def camera(**changes):
    return camsim.Camera.from_yaml("mono-345", lens=LENS).replace(**changes)


def exposed(one, *, light=None, exposure=EXPOSURE, size=8, reflectance=1.0, noise=False):
    return one.expose(
        camsim.Scene(background=reflectance),
        light=light or camsim.Light("D55", illuminance_lux=500),
        exposure=exposure,
        region=camsim.Region(rows=size, cols=size),
        noise=noise,
        tolerance=1e-3,
    )


@pytest.mark.parametrize(
    ("lens", "opening"),
    [
        (camsim.AnnularAiry(f_number=8.0, obstruction=0.4), 0.84),
        (camsim.Wavefront(f_number=8.0, pupil=camsim.Pupil(shape="square")), 4.0 / math.pi),
        (camsim.Wavefront(f_number=8.0, pupil=camsim.Pupil(shape="bladed", blades=6)), 1.5 * math.sqrt(3.0) / math.pi),
    ],
)
def test_light_goes_with_the_pupils_area(lens, opening):
    """An obstruction took none of it."""
    whole, one = (exposed(camera(lens=each)).mean_electrons.mean() for each in (LENS, lens))
    assert one / whole == pytest.approx(opening, rel=1e-12)


@pytest.mark.parametrize(
    "bends",
    [camsim.PolynomialResponse((0.5,), 10_700.0), camsim.ResponseTable((0, 5000, 10_700), (0, 5000, 7000))],
)
def test_auto_exposure_knows_that_the_read_out_bends(bends):
    """White at 67 … 100 % of black..white in place of 80, and a truth that was cut far below the camera's own white."""
    one = camera(nonlinearity=bends)
    frame = exposed(one, exposure=camsim.Exposure(time_s="auto", iso=100))
    assert (frame.mosaic.mean() - 64) / (frame.white_level_dn - 64) == pytest.approx(0.8, abs=1e-3)
    brighter = camsim.Exposure(time_s=frame.time_s * frame.clips_at_e / frame.mean_electrons.mean(), iso=100)
    assert exposed(one, exposure=brighter).mosaic.mean() == pytest.approx(frame.white_level_dn, abs=1.0)


def test_full_photosites_are_counted_as_clipped():
    """Read noise scatters codes of a full well about white: half of them were counted."""
    frame = exposed(camera(), exposure=camsim.Exposure(time_s=10.0, iso=100), size=32, noise=True)
    assert frame.report.signal[0].clipped_photosites == 32 * 32
    adc = camera().adc
    offsets = type(adc)(
        bit_depth=adc.bit_depth, black_level_dn=64, electrons_per_dn=adc.electrons_per_dn, base_iso=adc.base_iso,
        black_offsets_dn=((0, -50), (30, -50)),
    )  # fmt: skip
    frame = exposed(camera(adc=offsets), exposure=camsim.Exposure(time_s=10.0, iso=100), size=32)
    assert frame.report.signal[0].clipped_photosites == 32 * 32


def test_no_photon_noise_is_told_where_there_is_none():
    assert noise_profile(exposed(camera(), noise=True))[0] > 0.0
    assert noise_profile(exposed(camera()))[0] == 0.0
    assert noise_profile(exposed(camera(shot_noise=None), noise=True))[0] == 0.0


@pytest.mark.parametrize(
    ("bends", "iso"),
    [
        (camsim.PolynomialResponse((0.5,), 10_700.0), 100),
        (camsim.PolynomialResponse((-0.4,), 10_700.0), 800),
        (camsim.ResponseTable((0, 500, 10_700), (0, 500, 7000)), 100),
    ],
)
def test_the_noise_profile_of_a_bent_read_out_holds_at_mid_grey(bends, iso):
    """Scatter of a flat's frames, fixed patterns away: what the file said was 0.89 … 1.35 times the σ."""
    one = camera(nonlinearity=bends, prnu=None, dsnu=None, dark_current=None)
    linear = exposed(one, exposure=camsim.Exposure(time_s="auto", iso=iso))
    charge_e = one.charge_at_e(0.18, iso)
    at_grey = camsim.Exposure(time_s=linear.time_s * charge_e / linear.mean_electrons.mean(), iso=iso)
    frame = exposed(one, exposure=at_grey, size=200, noise=True)
    x = (frame.mosaic - 64.0) / (frame.white_level_dn - 64.0)
    assert x.mean() == pytest.approx(0.18, rel=4e-3)
    slope, floor = noise_profile(frame)
    # The variance of n values has a relative standard deviation of sqrt(2/n).
    assert x.var() == pytest.approx(slope * x.mean() + floor, rel=STATISTICAL * math.sqrt(2.0 / x.size))


def test_noise_models_of_data_sets(tmp_path):
    """Crosstalk averages PRNU, 8110 DN² in place of 3780; black offsets lay in no column."""
    kernel = [[0.02, 0.08, 0.02], [0.08, 0.6, 0.08], [0.02, 0.08, 0.02]]
    camsim.dataset(
        {
            "scene": "flat-field",
            "sensor": "mono-345",
            "set": {
                "region": {"rows": 300, "cols": 300},
                "render.tolerance": 1e-2,
                "exposure": {"iso": 100, "time_s": 0.025},
                "sensor.charge.prnu": 0.03,
                "sensor.charge.crosstalk": kernel,
                "sensor.readout.black_offsets_dn": [[0, 40], [20, -30]],
            },
            "crops": {"rows": 251, "cols": 251, "each": 1},
            "shards": "files",
            "splits": {"train": 1, "val": 0, "test": 0},
        },
        tmp_path,
        workers=0,
    )
    arrays, about = camsim.read_pair(tmp_path, 0)
    light = arrays["clean"] / about["electrons_per_dn"]
    black = about["black_level_dn"] + np.tile(about["black_offsets_dn"], (126, 126))[:251, :251]
    off = arrays["noisy"] - black - light - about["dark_dn"]
    model = about["shot_dn"] * (light + about["dark_dn"]) + about["read_dn2"] + (about["prnu"] * light) ** 2
    assert np.mean(off**2) == pytest.approx(np.mean(model + about["dsnu_dn"] ** 2), rel=0.03)
    for row, col in np.ndindex(2, 2):
        assert abs(off[row::2, col::2].mean()) < 5.0 * off.std() / 125.0 + 0.2


def test_noise_that_is_cut_is_an_empty_cell(tmp_path):
    """An SNR of 259 404: codes of full photosites lie below white by read noise, and were taken for good ones."""
    study = {
        "scene": "flat-field",
        "sensor": "mono-345",
        "set": {"region": {"rows": 60, "cols": 60}, "render.tolerance": 1e-2, "exposure.iso": 100},
        "vary": {"exposure.time_s": [0.01, 0.035, 1.0]},
        "measure": ["noise"],
        "files": ["{index}.npy"],
    }
    camsim.sweep(study, tmp_path, workers=0)
    with (tmp_path / "manifest.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert 50.0 < float(rows[0]["noise_Y_e"]) < 65.0
    assert [row["noise_Y_e"] for row in rows[1:]] == ["", ""]
    assert all("noise: codes of Y are cut at white or at 0" in row["message"] for row in rows[1:])


@dataclass(frozen=True)
class Odd:
    """A blur of one's own with a fault."""

    fault: Callable[[np.ndarray, np.ndarray, float], np.ndarray]
    f_number: float = 8.0
    transmission: float = 1.0

    def otf(self, fx, fy, wavelength_nm):
        return self.fault(np.exp(-60.0 * (np.asarray(fx) ** 2 + np.asarray(fy) ** 2)), fx, wavelength_nm)


@pytest.mark.parametrize(
    "fault",
    [
        lambda one, fx, nm: one * (np.nan if nm < 500.0 else 1.0),
        lambda one, fx, nm: one * (2.0 if nm < 500.0 else 1.0),
        lambda one, fx, nm: np.where(one == 1.0, 1.0, 0.5 * one),
        lambda one, fx, nm: one * np.exp(9j * np.abs(fx)),
    ],
    ids=["nan", "twice", "step", "odd"],
)
def test_a_stage_of_ones_own_is_looked_at_at_every_wavelength(fault):
    """NaN below 500 nm: a flat picture, and an estimate of 0."""
    scene = camsim.Scene(background=0.2, shapes=[camsim.Rectangle(width_um=7.0, height_um=5.0, reflectance=0.9)])
    grid, stages = camsim.Grid(rows=4, cols=4, pitch_um=4.0), [Odd(fault), camsim.SquarePhotosite(side_um=4.0)]
    with pytest.raises(InvalidValueError, match=r"Odd\.otf"):
        camsim.render(scene, stages, grid, wavelength_nm=450.0, tolerance=1e-4)


def test_a_study_takes_the_seeds_that_it_is_told(tmp_path):
    """A seed in a table was said in the manifest and not taken; scenes with seeds of their own had one noise."""
    small, files = {"region": {"rows": 8, "cols": 8}}, "{index}.npy"

    def rows(name, **study):
        return camsim.sweep({"scene": "flat-field", "files": files} | study, tmp_path / name, workers=0).rows

    varied = rows("a", set=small, vary={"noise": [{"seed": 6}, {"seed": 5}]})
    assert [row["noise_seed"] for row in varied] == [row["seed"] for row in varied] == [6, 5]
    assert len({row["sha256"] for row in varied}) == 2
    same = rows("b", set=small | {"noise": {"seed": 5}}, vary={"exposure.iso": [200, 400]})
    assert [row["seed"] for row in same] == [5, 5]
    text = (PROJECT / "scenes" / "flat-field.yaml").read_text(encoding="utf-8")
    for name, seed in (("one", 2), ("other", 1)):
        (tmp_path / f"{name}.yaml").write_text(text.replace("seed: 1}", f"seed: {seed}}}"), encoding="utf-8")
    one = rows("c", set=small, scene=[str(tmp_path / "one.yaml"), str(tmp_path / "other.yaml")])
    assert len({row["seed"] for row in one}) == len({row["sha256"] for row in one}) == 2


@pytest.mark.parametrize("fraction", [0.25, 1.0])
def test_gains_have_the_mean_and_deviation_that_are_said(fraction):
    """Cut at 0, the mean of dark current with a DCNU of 1 was 8 % too high, and its deviation 0.87."""
    normals = np.random.default_rng(3).standard_normal(1_000_000).astype(np.float32)
    one = gains(fraction, normals)
    assert one.min() >= 0.0
    assert one.mean() == pytest.approx(1.0, abs=STATISTICAL * fraction / 1000.0)
    assert one.std() == pytest.approx(fraction, rel=0.02)


def test_white_is_the_code_at_which_a_half_integer_well_clips():
    adc = camsim.Adc(bit_depth=12, black_level_dn=65, electrons_per_dn=5.0, base_iso=100.0)
    for full_well_e in (10002.5, 10007.5, 10000.0):
        full = adc.quantise(np.array([full_well_e]), iso=100.0)
        assert adc.white_level_dn(100.0, full_well_e) == full[0]


def test_gradients_behind_a_gaussian_of_any_size():
    """Of a Gaussian 77 spots away there is no light at all, and it was divided by."""
    frame = camsim.capture(
        "flat-field",
        sensor="mono-345",
        overrides=[
            "lens={kind: gaussian, f_number: 4, sigma_um: 1}",
            "region={rows: 256, cols: 256}",
            "render.tolerance=1e-3",
            "scene.shapes=[{kind: linear-gradient, width: 200, height: 200}]",
        ],
        products=("electrons",),
    )
    assert np.ptp(frame.mean_electrons) > 0.0


@pytest.mark.parametrize(
    ("key", "what"),
    [("scene.background.reflectance", "a reflectance"), ("lens.transmission", "the lens's transmission")],
)
def test_tables_beside_the_light_are_noted(key, what):
    table = "{wavelength_nm: [4000, 7000], values: [0.1, 0.4]}"
    frame = camsim.capture("flat-field", sensor="mono-345", overrides=["region={rows: 4, cols: 4}", f"{key}={table}"])
    assert any(note.text.startswith(f"{what} is known from 4000 to 7000 nm") for note in frame.report.notes)
