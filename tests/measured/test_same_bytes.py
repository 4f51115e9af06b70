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
