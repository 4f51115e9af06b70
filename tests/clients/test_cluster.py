"""A dask scheduler and workers started by hand: the files of a sweep are those of one process."""

import contextlib
import hashlib
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import camsim
from camsim.errors import CamsimError, InvalidValueError
from camsim.study import batches

pytestmark = pytest.mark.clients

STUDY = {
    "scene": "slanted-edge",
    "sensor": "mono-345",
    "set": {"region": {"rows": 8, "cols": 9}, "render.tolerance": 1e-3},
    "vary": {"lens.f_number": {"linear": [4, 16, 8]}},
}


def sums(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.dng"))}


@pytest.fixture
def cluster(tmp_path, request):
    """Start a scheduler and two workers, in the environment that a test names."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    place = f"tcp://127.0.0.1:{port}"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port)]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", place, "--nthreads", "1", "--no-dashboard"]
    words = [[*dask, "--no-dashboard"], worker, worker]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    quiet["env"] = os.environ | getattr(request, "param", lambda place: {})(tmp_path)
    programs = [subprocess.Popen(one, start_new_session=True, **quiet) for one in words]
    yield SimpleNamespace(address=place, scheduler=programs[0])
    for program in programs:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(program.pid, signal.SIGKILL)
        program.wait()


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_scheduler_that_dies_is_said_and_what_was_finished_is_kept(cluster, tmp_path, monkeypatch):
    monkeypatch.setattr(batches, "TASK", 0.0)

    def kill(stage, fraction):
        if stage == "capture":
            os.killpg(cluster.scheduler.pid, signal.SIGKILL)

    with pytest.raises(ConnectionError, match="is lost; what is finished is kept, sweep again to go on"):
        camsim.sweep(STUDY, tmp_path, scheduler=cluster.address, progress=kill)
    again = camsim.sweep(STUDY, tmp_path, workers=0)
    assert again.found > 0
    assert again.found + again.taken == 8


@pytest.mark.filterwarnings("ignore::ResourceWarning")  # sockets of the cluster's own
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_cluster_takes_the_same_files(cluster, tmp_path, monkeypatch):
    """As many tasks as captures: more than are handed out at first."""
    monkeypatch.setattr(batches, "TASK", 0.0)
    camsim.sweep(STUDY, tmp_path / "here", workers=0)
    done = camsim.sweep(STUDY, tmp_path / "there", scheduler=cluster.address)
    assert (done.taken, done.failed) == (8, 0)
    assert sums(tmp_path / "there") == sums(tmp_path / "here")


def older(place):
    """Return an environment in which camsim is of another version."""
    about = place / "older" / "camsim_spectral-0.0.9.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: camsim-spectral\nVersion: 0.0.9\n", encoding="ascii")
    (about.parent / "camsim").symlink_to(Path(camsim.__file__).parent)
    return {"PYTHONPATH": str(about.parent)}


def none(place):
    """Return an environment in which there is no camsim that can be imported."""
    (place / "none" / "camsim").mkdir(parents=True)
    (place / "none" / "camsim" / "__init__.py").write_text("raise ImportError('no such thing')", encoding="ascii")
    return {"PYTHONPATH": str(place / "none")}


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("cluster", "has"), [(older, "has camsim 0.0.9"), (none, "cannot import camsim")], indirect=["cluster"]
)
def test_a_worker_of_another_version_is_named_before_anything_is_taken(cluster, has, tmp_path):
    with pytest.raises(CamsimError, match=rf"the worker tcp://127.0.0.1:\d+ {has}.*; install camsim 0\.1\.0 there"):
        camsim.sweep(STUDY, tmp_path / "out", scheduler=cluster.address)
    assert not list((tmp_path / "out").glob("*.dng"))


def test_no_scheduler_is_said(tmp_path):
    with pytest.raises(InvalidValueError, match=r"--scheduler: no scheduler at 'tcp://127.0.0.1:9'"):
        camsim.sweep(STUDY, tmp_path, scheduler="tcp://127.0.0.1:9")
    with pytest.raises(InvalidValueError, match="workers: are the scheduler's"):
        camsim.sweep(STUDY, tmp_path, scheduler="tcp://127.0.0.1:9", workers=2)
