"""The same capture is the same bytes: again, on other threads, from YAML or from Python; another seed is not."""

import hashlib
import os
import subprocess
import sys
import threading

import numpy as np
import pytest

import camsim

SMALL = ("region.rows=150", "region.cols=140", "region.origin=[800, 1310]")

CORES = ("Haswell", "Sandybridge")  # which OpenBLAS is told to take its kernels of; make test-machines has more

IN_A_PROCESS_OF_ITS_OWN = """
import os, sys
threads = int(os.environ.get("NUMBA_NUM_THREADS", 0))
cores = sorted(os.sched_getaffinity(0))[:threads] if sys.platform == "linux" else ()
if cores:
    os.sched_setaffinity(0, cores)
import camsim
frame = camsim.capture("slanted-edge", overrides=sys.argv[2:], seed=7)
camsim.save(frame, sys.argv[1] + ".dng")
camsim.save(frame, sys.argv[1] + ".npz")
"""

SCENE_YAML = """
camsim: scene/1
name: twin
sensor: twin-sensor.yaml
lens:
  kind: airy
  f_number: 5.6
  transmission: {wavelength_nm: [400, 500, 700], values: [0.8, 0.95, 0.9], outside: hold}
light: {illuminant: D65, illuminance_lux: 2500}
exposure: {time_s: 0.02, iso: 400, datetime: "2021-02-03 04:05:06"}
region: {rows: 66, cols: 80, origin: [7, 12]}
scene:
  unit: pixel
  background: {reflectance: neutral 8}
  shapes:
    - {kind: rectangle, width: 30.5, height: 18, centre: [-8, 3.25], rotate_deg: 12, reflectance: 0.05}
    - {kind: disc, radius: 9, centre: [14, -8], reflectance: red}
    - kind: polygon
      points: [[-30, -25], [2, -20], [-12, -4]]
      reflectance: {wavelength_nm: [450, 650], values: [0.1, 0.7], outside: hold}
render: {tolerance: 1.0e-5}
noise: {enabled: true, seed: 12}
"""
SENSOR_YAML = """
camsim: sensor/1
name: twin
serial: 42
frame: {rows: 90, cols: 120, pitch_um: 4.2}
photosite: {kind: square, fill_factor: 0.64}
olpf: {kind: four-spot, split_um: 3.1, source: made up}
cfa: {kind: bayer, pattern: GRBG}
quantum_efficiency: {curves: "Nikon 5100 (NPL)", per: energy, peak: 0.5, source: made up}
charge: {full_well_e: 30000, dark_current_e_per_s: 3, prnu: 0.01, dsnu_e: 1.5}
readout: {bit_depth: 14, black_level_dn: 512, base_iso: 100, electrons_per_dn: 2.0, read_noise_e: 4.0}
source: made up
"""


def dng_bytes(frame, tmp_path, name="a.dng"):
    camsim.save(frame, tmp_path / name, force=True)
    return (tmp_path / name).read_bytes()


@pytest.fixture(scope="module")
def digest(tmp_path_factory):
    """The capture of this process, whatever its threads."""
    return digest_of(tmp_path_factory.mktemp("here"))


def digest_of(folder):
    """Of a DNG, whose matrices come from sums of floats, and a NPZ, which holds floats of 64 bits."""
    if not (folder / "a.dng").exists():
        frame = camsim.capture("slanted-edge", overrides=SMALL, seed=7)
        for suffix in ("dng", "npz"):
            camsim.save(frame, folder / f"a.{suffix}")
    return [hashlib.sha256((folder / f"a.{suffix}").read_bytes()).hexdigest() for suffix in ("dng", "npz")]


def test_twice_in_a_row(digest, tmp_path):
    assert digest_of(tmp_path) == digest


@pytest.mark.parametrize(
    "how",
    [{"NUMBA_NUM_THREADS": "1"}, {"NUMBA_NUM_THREADS": "2"}, *({"OPENBLAS_CORETYPE": core} for core in CORES)],
)
def test_on_one_thread_on_two_and_on_other_processors(digest, tmp_path, how):
    subprocess.run(
        [sys.executable, "-W", "error", "-c", IN_A_PROCESS_OF_ITS_OWN, str(tmp_path / "a"), *SMALL],
        check=True,
        cwd=tmp_path,
        env={**os.environ, **how},
        timeout=600,
    )
    assert digest_of(tmp_path) == digest


def test_another_seed_differs_everywhere(tmp_path):
    frames = [camsim.capture("slanted-edge", overrides=SMALL, seed=seed) for seed in (7, 8)]
    np.testing.assert_array_equal(frames[0].mean_electrons, frames[1].mean_electrons)
    assert np.mean(frames[0].mosaic != frames[1].mosaic) > 0.8
    assert dng_bytes(frames[0], tmp_path) != dng_bytes(frames[1], tmp_path)


def python_twin():
    """Every stage by hand, from the numbers of the two files above."""
    pitch_um = 4.2
    camera = camsim.Camera(
        name="twin",
        serial=42,
        rows=90,
        cols=120,
        pitch_um=pitch_um,
        lens=camsim.Airy(f_number=5.6, transmission=camsim.Curve((400, 500, 700), (0.8, 0.95, 0.9), outside="hold")),
        olpf=camsim.FourSpotOlpf(split_um=3.1),
        photosite=camsim.SquarePhotosite.from_fill_factor(pitch_um=pitch_um, fill_factor=0.64),
        cfa=camsim.Cfa.bayer("GRBG"),
        quantum_efficiency=camsim.QuantumEfficiency.named("Nikon 5100 (NPL)", peak=0.5, source="made up"),
        prnu=camsim.Prnu(0.01),
        dark_current=camsim.DarkCurrent(3.0),
        full_well=camsim.FullWell(30000.0),
        read_noise=camsim.ReadNoise(4.0),
        dsnu=camsim.Dsnu(1.5),
        adc=camsim.Adc(bit_depth=14, black_level_dn=512, electrons_per_dn=2.0, base_iso=100.0),
    )
    scene = camsim.Scene(
        background=camsim.reflectance("neutral 8"),
        shapes=[
            camsim.Rectangle(
                width_um=30.5 * pitch_um,
                height_um=18 * pitch_um,
                centre_um=(-8 * pitch_um, 3.25 * pitch_um),
                rotate_deg=12.0,
                reflectance=0.05,
            ),
            camsim.Disc(
                radius_um=9 * pitch_um,
                centre_um=(14 * pitch_um, -8 * pitch_um),
                reflectance=camsim.reflectance("red"),
            ),
            camsim.Polygon(
                points_um=[(x * pitch_um, y * pitch_um) for x, y in ((-30, -25), (2, -20), (-12, -4))],
                reflectance=camsim.Curve((450, 650), (0.1, 0.7), outside="hold"),
            ),
        ],
    )
    return camera.expose(
        scene,
        light=camsim.Light("D65", illuminance_lux=2500.0),
        exposure=camsim.Exposure(time_s=0.02, iso=400.0, datetime="2021-02-03 04:05:06"),
        seed=12,
        region=camsim.Region(rows=66, cols=80, origin=(7, 12)),
        tolerance=1e-5,
    )


def test_yaml_and_its_python_twin(tmp_path):
    (tmp_path / "twin.yaml").write_text(SCENE_YAML, encoding="utf-8")
    (tmp_path / "twin-sensor.yaml").write_text(SENSOR_YAML, encoding="utf-8")
    frame, twin = camsim.capture(tmp_path / "twin.yaml"), python_twin()
    np.testing.assert_array_equal(frame.mosaic, twin.mosaic)
    assert dict(frame.description) == dict(twin.description)
    assert dng_bytes(frame, tmp_path, "yaml.dng") == dng_bytes(twin, tmp_path, "python.dng")


def test_from_yaml_is_the_camera_of_the_capture():
    camera = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0))
    scene = camsim.Scene(background=0.18)
    frame = camera.expose(
        scene,
        light=camsim.Light("D55", illuminance_lux=5000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=200.0),
        seed=1,
        region=camsim.Region(rows=20, cols=20),
    )
    capture = camsim.capture("flat-field", overrides=["region.rows=20", "region.cols=20"])
    np.testing.assert_array_equal(frame.mosaic, capture.mosaic)


def test_the_products_asked_for_change_no_code(tmp_path):
    alone = camsim.capture("slanted-edge", overrides=SMALL, seed=7, products=("mosaic",))
    all_of_them = camsim.capture(
        "slanted-edge", overrides=SMALL, seed=7, products=("mosaic", "electrons", "truth", "preview")
    )
    assert alone.truth is None
    assert all_of_them.truth is not None
    assert all_of_them.mosaic.tobytes() == alone.mosaic.tobytes()
    one = np.take_along_axis(all_of_them.truth, alone.channel_index[:, :, None].astype(int), axis=2)[:, :, 0]
    np.testing.assert_array_equal(one, alone.mean_electrons.astype(np.float32))


def test_a_window_has_the_full_frames_fixed_patterns(tmp_path):
    """Without temporal noise a window is that slice of the frame, PRNU and DSNU included, to the tolerance."""
    quiet = camsim.Camera.from_yaml("d40-like", lens=camsim.Airy(f_number=8.0)).replace(
        rows=140, cols=100, read_noise=None, prnu=camsim.Prnu(0.05), dsnu=camsim.Dsnu(50.0)
    )
    scene = camsim.Scene(
        background=0.7, shapes=[camsim.Rectangle(width_um=200, height_um=150, rotate_deg=20, reflectance=0.1)]
    )
    light = camsim.Light("D55", illuminance_lux=5000.0)
    # So long that shot noise is small beside the fixed patterns.
    exposure = camsim.Exposure(time_s=10.0, iso=200.0)
    camera = quiet.replace(full_well=None)
    whole = camera.expose(scene, light=light, exposure=exposure)
    region = camsim.Region(rows=60, cols=30, origin=(51, 33))
    window = camera.expose(scene, light=light, exposure=exposure, region=region)
    part = np.s_[51:111, 33:63]
    np.testing.assert_array_equal(window.channel_index, whole.channel_index[part])
    np.testing.assert_allclose(window.mean_electrons, whole.mean_electrons[part], rtol=1e-5)
    # Gains of 5 % agree to shot noise: 1/√(electrons), some 0.05 %.
    gain, gain_of_whole = (f.electrons / f.mean_electrons for f in (window, whole))
    assert np.std(gain - gain_of_whole[part]) < 0.1 * np.std(gain)


def test_two_python_threads_at_a_time():
    """The same frames as one after the other."""
    names = ["slanted-edge", "paper-square", "slanted-edge", "paper-square"]

    def taken(name):
        return camsim.capture(name, sensor="d40-like", overrides=SMALL, seed=9).mosaic.tobytes()

    one_by_one = {name: taken(name) for name in set(names)}
    found = [None] * len(names)

    def take(i):
        found[i] = taken(names[i])

    threads = [threading.Thread(target=take, args=(i,)) for i in range(len(names))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [one_by_one[name] for name in names]
