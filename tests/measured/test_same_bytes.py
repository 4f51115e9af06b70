"""The same capture is the same bytes: again, and on other threads; another seed is not."""

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
    [{"NUMBA_NUM_THREADS": "1"}, *({"OPENBLAS_CORETYPE": core, "NUMBA_NUM_THREADS": "2"} for core in CORES)],
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


def test_another_seed_differs_everywhere():
    frames = [camsim.capture("slanted-edge", overrides=SMALL, seed=seed) for seed in (7, 8)]
    np.testing.assert_array_equal(frames[0].mean_electrons, frames[1].mean_electrons)
    assert np.mean(frames[0].mosaic != frames[1].mosaic) > 0.8


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
