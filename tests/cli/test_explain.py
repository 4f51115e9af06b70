"""``camsim explain`` says what is computed and what is not; ``--strict`` and the counters, as a user meets them."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from camsim import capture, files
from camsim.camera.frame import Frame
from camsim.cli import pairs, plot_mtf_map
from camsim.errors import InvalidValueError, OutputError
from camsim.files import save
from tests.tables import rows

from .conftest import Run, run_camsim

SHIPPED = ("colorchecker", "edge-chart", "flat-field")


def decisions_of(camsim: Run, *arguments: str) -> dict[str, list[str]]:
    done = camsim("explain", *arguments, "--json")
    assert done.returncode == 0, done.stderr
    stated: dict[str, list[str]] = {}
    for line in json.loads(done.stdout)["decisions"]:
        stated.setdefault(line["topic"], []).append(f"{line['decision']}: {line['reason']}")
    return stated


def test_every_decision_has_its_reason(camsim: Run, folder: Path) -> None:
    stated = decisions_of(camsim, "small.yaml")
    assert stated["engine"] == ["boundary: exact for this lens, and cheap"]
    assert stated["wavelengths"] == ["one: the light is a line"]
    assert stated["channels"] == ["each photosite in its own: nobody reads the other 2: no truth is written"]
    assert "ShotNoise()" in stated["noise"][0]
    assert stated["colour matrix"][0].startswith("fitted")
    assert [path.name for path in folder.iterdir()] == ["small.yaml"]


def test_what_is_switched_off_is_left_out(camsim: Run) -> None:
    stated = decisions_of(
        camsim, "small.yaml", "-o", "a.exr", "--set", "noise.enabled=false", "--set", "sensor.olpf=null"
    )
    assert stated["OLPF"] == ["left out: the camera has none: one spot"]
    assert stated["noise"] == ["no random number: noise is switched off"]
    assert stated["channels"] == ["all 3 everywhere: the truth is to be written"]
    assert stated["colour matrix"] == ["none: no DNG and no preview is written"]


def test_a_tilt_is_left_out(camsim: Run) -> None:
    """4·c·λ_ref·N along x: 4 · 0.5 · 0.55 µm · 8."""
    lens = "lens={kind: wavefront, f_number: 8, zernike_waves: [[2, 0.5], [8, 0.1]]}"
    (said,) = decisions_of(camsim, "small.yaml", "--set", lens)["tilt"]
    assert said.startswith("left out: it moves the pattern of every wavelength by 8.8 µm along x and 0 µm along y: ")


@pytest.mark.parametrize(("change", "said"), rows("notes.txt", "fall-off"))
def test_fall_off_is_told(camsim: Run, change: str, said: str) -> None:
    """Of 40 rows and 60 columns of 5 µm the corners are 0.5 · √(195² + 295²) µm from the axis."""
    window = ("sensor.frame={rows: 40, cols: 60, pitch_um: 5.0}", "region=null")
    options = [word for each in (*window, change) for word in ("--set", each)]
    assert decisions_of(camsim, "small.yaml", *options)["fall-off"] == [said]


def test_a_field_lens_dims(camsim: Run) -> None:
    """As its frames have it: a flat's corner over its middle, of a lens that was said to be even."""
    (said,) = decisions_of(camsim, "field-lens")["fall-off"]
    stated, words = said.split(" ", 1)
    assert words == "of the axis's light in the window's dimmest corner: the lens's own"
    window = ["region={rows: 2, cols: 2, origin: [200, 200]}", "region={rows: 2, cols: 2, origin: [1023, 1223]}"]
    flat = ["scene.shapes=[]", "render.tolerance=1e-3", "exposure.time_s=1e-3"]
    corner, middle = (capture("field-lens", overrides=[*flat, place]).mean_electrons[0, 0] for place in window)
    assert float(stated) == pytest.approx(corner / middle, abs=1e-4)


def test_the_engine_follows_the_tolerance_and_the_word(camsim: Run) -> None:
    engine = decisions_of(camsim, "small.yaml", "--set", "render.tolerance=1e-10")["engine"][0]
    assert "of one core expected, " in engine or "and cheap" in engine
    assert decisions_of(camsim, "small.yaml", "--set", "render.method=fourier")["engine"] == ["fourier: asked for"]


def test_it_can_be_read(camsim: Run) -> None:
    done = camsim("explain", "small.yaml", "--set", "sensor.frame.pitch_um=3")
    for word in (
        "16 × 20 photosites",
        "engine",
        "boundary",
        "time",
        "of one core",
        "memory",
        "error",
        "at most 0.0001",
        "photosites of 3 µm, camera D40-like, 4.88 µm, ",  # its name is what it was
    ):
        assert word in done.stdout


@pytest.mark.parametrize("scene", SHIPPED)
def test_every_shipped_scene(camsim: Run, scene: str) -> None:
    done = camsim("explain", scene, "--json")
    expected = json.loads(done.stdout)["expected"]
    assert 0.0 < sum(expected["seconds"].values()) < 60.0
    assert 1e6 < expected["memory_bytes"] < 2e9


@pytest.mark.parametrize(
    ("shapes", "error"),
    [
        ("[]", 0.0),
        ("[{kind: point-source, photosites: 3}]", 1e-4),
        ("[{kind: sine-grating, period: 9, width: 20, height: 20}]", 1e-4),
    ],
)
def test_what_has_no_edge_may_be_wrong_too(camsim: Run, shapes: str, error: float) -> None:
    done = camsim("explain", "small.yaml", "--set", f"scene.shapes={shapes}", "--json")
    stated = json.loads(done.stdout)
    assert stated["expected"]["error"] == error, done.stderr
    assert sum(line["topic"] == "wavelengths" for line in stated["decisions"]) == bool(error)


@pytest.mark.parametrize("kind", ["mtf", "psf", "qe", "spectra", "noise"])
def test_plots(camsim: Run, folder: Path, kind: str) -> None:
    done = camsim("explain", "small.yaml", "--plot", kind, "a.svg")
    assert done.returncode == 0, done.stderr
    assert "<svg" in (folder / "a.svg").read_text(encoding="utf-8")


def test_strict_captures_are_the_same_when_all_is_well(camsim: Run, folder: Path) -> None:
    assert camsim("capture", "small.yaml", "--strict", "-q", "-o", "a.dng").returncode == 0
    assert camsim("capture", "small.yaml", "-q", "-o", "b.dng").returncode == 0
    assert (folder / "a.dng").read_bytes() == (folder / "b.dng").read_bytes()


def test_the_report_counts_what_was_done(camsim: Run, folder: Path) -> None:
    done = camsim("capture", "small.yaml", "-q", "--json", "-o", "a.dng", "-o", "a.exr")
    work = json.loads(done.stdout)["work"]
    written = sum((folder / name).stat().st_size for name in ("a.dng", "a.exr"))
    assert (work["bytes_written"], work["colour_matrices"], work["channels"]) == (written, 1, 3)
    less = json.loads(
        camsim("capture", "small.yaml", "-q", "--json", "-o", "b.npy", "--set", "noise.enabled=false").stdout
    )["work"]
    assert (less["colour_matrices"], less["random_numbers"], less["channels"]) == (0, 0, 1)
    assert less["bytes_written"] < written
    stated = camsim("capture", "small.yaml", "-v", "-o", "c.dng").stderr
    assert "edges 4, " in stated
    assert "bytes written " in stated


def undrawn(patch: pytest.MonkeyPatch) -> None:
    def draw_map(*given: object) -> None:
        raise InvalidValueError("cannot be drawn")

    patch.setattr(plot_mtf_map, "draw_map", draw_map)


def unwritten(end: str) -> Callable[[pytest.MonkeyPatch], None]:
    """Return what makes writing of files whose names end so fail."""

    def change(patch: pytest.MonkeyPatch) -> None:
        def failing(frame: Frame, path: Path | str, **how: Any) -> Path:
            if str(path).endswith(end):
                raise OutputError("the disk is full")
            return save(frame, path, **how)

        for place in (files, pairs):
            patch.setattr(place, "save", failing)

    return change


FAILS = {
    "explain": (
        *(None, "not Wavefront; auto or fourier takes it", "explain", "slanted-edge"),
        *("--set", "render.method=boundary", "--plot", "mtf", "plot.png"),
        *("--set", "lens={kind: wavefront, f_number: 4, pupil: {shape: square}}"),
    ),
    "measure mtf": (
        *(undrawn, "cannot be drawn", "measure", "mtf", "edge.dng", "--roi", "0,0,60,60"),
        *("--csv", "a.csv", "--plot", "plot.png", "--map", "map.png"),
    ),
    "capture": (unwritten(".exr"), "the disk is full", "capture", "small.yaml", "-q", "-o", "a.dng", "-o", "a.exr"),
    "recapture": (unwritten(".exr"), "disk is full", "recapture", "edge.dng", "-q", "-o", "a.dng", "-o", "a.exr"),
    "frames": (
        *(unwritten("-2.exr"), "the disk is full"),
        *("capture", "small.yaml", "-q", "--frames", "3", "-o", "a.dng", "-o", "a.exr"),
    ),
    "pairs": (unwritten(".exr"), "the disk is full", "capture", "small.yaml", "-q", "--pairs", "pairs"),
}  # fmt: skip


@pytest.fixture(scope="module")
def edge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A capture of an edge."""
    there = tmp_path_factory.mktemp("edge")
    words = ("capture", "knife-edge", "-q", "-o", "edge.dng", "--set", "region={rows: 60, cols: 60}")
    run_camsim(there, *words).check_returncode()
    return there / "edge.dng"


@pytest.mark.parametrize(("change", "said", "words"), [(c, s, w) for c, s, *w in FAILS.values()], ids=FAILS)
def test_a_command_that_fails_leaves_no_file(
    camsim: Run, edge: Path, folder: Path, monkeypatch: pytest.MonkeyPatch, change: Any, said: str, words: list[str]
) -> None:
    """A plot lay there of a command that had failed, and to the second try it said that it exists."""
    shutil.copy(edge, folder)
    before = sorted(path.name for path in folder.iterdir())
    if change is not None:
        change(monkeypatch)
    refused = camsim(*words)
    assert refused.returncode == 2, refused.stderr
    assert re.search(said, refused.stderr)
    assert sorted(path.name for path in folder.iterdir()) == before
