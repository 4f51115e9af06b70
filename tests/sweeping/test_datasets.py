"""Data sets: samples that agree with their captures, whatever holds them, and splits that share no scene."""

import io
import json
import tarfile

import numpy as np
import pytest

import camsim
from camsim.camera.capture import Capture
from camsim.errors import CamsimError, ConfigError, InputError, OutputError
from camsim.study import check_dataset, dataset, forecast_dataset, read_dataset, read_pair, samples, shards
from camsim.study.captures import captures_of
from camsim.study.dataset import shards_of
from tests.tables import rows

MADE_OF = {
    "scene": ["slanted-edge", "flat-field", "grey-steps", "checkerboard"],
    "sensor": "d40-like",
    "set": {"region": {"rows": 24, "cols": 30}, "render.tolerance": 1e-2, "exposure.time_s": "auto"},
    "vary": {"exposure.iso": [200, 1600]},
    "crops": {"rows": 8, "cols": 10, "each": 3},
    "splits": {"train": 0.5, "val": 0.25, "test": 0.25},
    "samples_per_shard": 10,
    "sources": ["Greys: nobody's."],
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tar")
    return dataset(MADE_OF, folder, workers=0)


def members(folder, row):
    with tarfile.open(folder / row["file"]) as tar:
        names = [name for name in tar.getnames() if name.startswith(row["key"])]
        return {name.split(".", 1)[1]: tar.extractfile(name).read() for name in names}


def test_samples_are_windows_of_captures(made):
    assert len(made.rows) == 4 * 2 * 3
    row = made.rows[13]
    assert (row["index"], row["capture"], row["scene"], row["exposure_iso"]) == (13, 4, "grey-steps", 200)
    content = members(made.folder, row)
    facts = json.loads(content["json"])
    overrides = ["region={rows: 24, cols: 30}", "render.tolerance=1e-2", "exposure.time_s=auto", "exposure.iso=200"]
    ready = camsim.load("grey-steps", sensor="d40-like", overrides=overrides, seed=facts["seed"])
    frame = ready.frame(products=("mosaic", "truth"))
    window = np.s_[row["row"] : row["row"] + 8, row["col"] : row["col"] + 10]
    for part, whole in (("noisy", frame.mosaic), ("clean", frame.mean_electrons), ("truth", frame.truth)):
        array = np.load(io.BytesIO(content[f"{part}.npy"]))
        np.testing.assert_array_equal(array, np.asarray(whole)[window].astype(array.dtype))
    assert (row["row"] % 2, row["col"] % 2) == (0, 0)  # the filters of a sample are those that it says
    assert facts["cfa"] == "/".join(frame.cfa_pattern)
    d65 = [0.9505, 1.0, 1.0890]
    assert max(np.array(facts["xyz_to_camera_d65"]) @ d65) == pytest.approx(1.0, abs=2e-3)


def test_no_scene_is_in_two_splits_and_none_is_empty(made):
    splits = {}
    for row in made.rows:
        splits.setdefault(row["scene"], set()).add(row["split"])
    assert all(len(each) == 1 for each in splits.values())
    count = [sum(each == {name} for each in splits.values()) for name in ("train", "val", "test")]
    assert count == [2, 1, 1]


def test_a_scene_in_photosites_is_the_same_on_every_pitch():
    """In µm it is another one on each: dealt out one by one, scenes would be in two splits."""
    read = read_dataset({**MADE_OF, "vary": {"sensor.frame.pitch_um": [4, 5, 6]}})
    captures = captures_of(read, ("mosaic",), lambda stage, fraction: None)
    sources = {source.identity: source for shard in shards_of(read, captures) for source in shard.sources}
    splits = {}
    for source in sources.values():
        splits.setdefault(source.stated["scene"], set()).add(source.split)
    assert sorted(split for (split,) in splits.values()) == ["test", "train", "train", "val"]


def test_shards_of_an_earlier_making_go(tmp_path):
    """Whoever reads all shards of a split would else have samples of another one; in a folder that was none's they
    are somebody's."""
    made_of = {**MADE_OF, "hold": ["noisy"]}
    (tmp_path / "train-00099.tar").write_text("somebody's")
    dataset({**made_of, "shards": "files", "samples_per_shard": 5}, tmp_path, workers=0)
    (tmp_path / "train-00099.tar").unlink()
    (tmp_path / "train-notes.txt").write_text("one's own")
    for form, splits in (("files", {"train": 1, "val": 0, "test": 0}), ("npy", MADE_OF["splits"])):
        made = dataset({**made_of, "shards": form, "splits": splits}, tmp_path, workers=0)
        there = {p.relative_to(tmp_path).as_posix() for p in tmp_path.glob("*-0*") if p.is_file()}
        there |= {p.relative_to(tmp_path).as_posix() for p in tmp_path.glob("*-0*/*")}
        assert there == {file for row in made.rows for file in (row["file"], *row["also"])}
        assert "files of shards that this data set has no more were removed" in made.notes[0].text
    assert not [path for path in tmp_path.glob("*-0*") if path.is_dir()]
    assert (tmp_path / "train-notes.txt").exists()


def test_a_study_and_a_data_set_do_not_share_a_folder(tmp_path):
    """The manifest of the other was written over, and with the journal all that was known of what is there."""
    study = {"scene": "flat-field", "sensor": "mono-345", "set": {"region": {"rows": 8, "cols": 8}}}
    made_of = {**study, "crops": {"rows": 8, "cols": 8}, "splits": {"train": 1, "val": 0, "test": 0}}
    for first, then in ((camsim.sweep, camsim.dataset), (camsim.dataset, camsim.sweep)):
        folder, asked = tmp_path / first.__name__, {camsim.sweep: study, camsim.dataset: made_of}
        first(asked[first], folder, workers=0)
        before = (folder / "manifest.csv").read_bytes()
        with pytest.raises(CamsimError, match="its manifest is of another kind; give a study and a data set a folder"):
            then(asked[then], folder, workers=0)
        assert (folder / "manifest.csv").read_bytes() == before
        assert first(asked[first], folder, workers=0).found == 1


@pytest.mark.parametrize("index", ["1", None, 1.0, True, -1, 2**63])
def test_samples_are_read_by_their_number(made, index):
    with pytest.raises(CamsimError, match=r"index: must be a whole number from 0 to 2\^63 − 1, not"):
        read_pair(made.folder, index)
    assert read_pair(made.folder, np.int64(7))[1]["key"] == "00000007"


def test_the_card_says_whose_the_sources_are(made):
    assert "* Greys: nobody's." in (made.folder / "README.md").read_text(encoding="utf-8")
    assert "Greys: nobody's." in json.loads((made.folder / "croissant.json").read_text(encoding="utf-8"))["creditText"]


def test_shards_of_each_split_are_numbered_from_none_on(made):
    """A brace pattern finds no file where numbers are left out: those of all splits together leave most of them out."""
    for split in ("train", "val", "test"):
        each = [row for row in made.rows if row["split"] == split]
        assert [row["file"] for row in each] == [f"{split}-{place // 10:05d}.tar" for place in range(len(each))]
    for row in made.rows:
        assert row["key"] == f"{row['index']:08d}"
    places = [(row["file"], row["place"]) for row in made.rows]
    assert len(set(places)) == len(places)


@pytest.mark.parametrize(("form", "some"), [("npy", "train-*-noisy.npy"), ("files", "train-*/00000000.noisy.npy")])
def test_other_shards_hold_the_same_and_are_made_again_when_one_is_not_whole(made, tmp_path, form, some):
    study = {**MADE_OF, "shards": form}
    first = dataset(study, tmp_path, workers=0)
    for index in (0, 9, 10, 23):
        arrays, row = read_pair(tmp_path, index)
        others, _ = read_pair(made.folder, index)
        assert set(arrays) == {"noisy", "clean", "truth"}
        for part, array in arrays.items():
            np.testing.assert_array_equal(array, others[part])
        assert row["split"] == made.rows[index]["split"]
    assert dataset(study, tmp_path, workers=0).found == first.made == 4
    file = next(path for pattern in (some, some.replace("train", "*")) for path in sorted(tmp_path.glob(pattern)))
    whole = file.read_bytes()
    file.write_bytes(whole[:-3])
    again = dataset(study, tmp_path, workers=0)
    assert (again.made, again.found) == (1, 3)
    assert file.read_bytes() == whole


def test_captures_share_a_rendering_across_shards_and_none_is_lost_where_one_fails(tmp_path, monkeypatch):
    """Keys that change the image vary innermost, and every sample has a shard of its own."""
    study = {
        "scene": ["flat-field", "grey-steps", "checkerboard"],
        "set": {"region": {"rows": 8, "cols": 8}, "render.tolerance": 1e-2},
        "vary": {"noise.seed": [1, 2], "lens.f_number": [4, 8]},
        "crops": {"rows": 4, "cols": 4},
        "samples_per_shard": 1,
        "hold": ["noisy", "clean"],
    }
    rendered, real, cut = [], Capture.optical_image, samples.into_tar
    monkeypatch.setattr(
        Capture, "optical_image", lambda self, **how: rendered.append(how["products"]) or real(self, **how)
    )

    def full(path):
        if path.name == "00000005.tar":
            raise OutputError("the disk is full")
        return cut(path)

    monkeypatch.setattr(samples, "into_tar", full)
    first = dataset(study, tmp_path, workers=0)
    assert (first.made, first.failed) == (11, 1)
    assert [(r["index"], r["message"]) for r in first.rows if r["status"] == "failed"] == [(5, "the disk is full")]
    assert rendered == [("mosaic",)] * 6  # no truth is held, and none is rendered
    monkeypatch.setattr(samples, "into_tar", cut)
    again = dataset(study, tmp_path, workers=0)
    assert (again.made, again.found, len(rendered)) == (1, 11, 7)
    assert not list((tmp_path / ".sweep").glob("captures"))


def test_a_data_set_that_was_killed_takes_no_capture_twice(made, tmp_path, monkeypatch):
    """Killed while shards are packed: what was cut is there, and the shards are those of one go."""
    whole = shards.Shard.packed

    def killed(self, *where):
        raise KeyboardInterrupt

    monkeypatch.setattr(shards.Shard, "packed", killed)
    with pytest.raises(KeyboardInterrupt):
        dataset(MADE_OF, tmp_path, workers=0)
    monkeypatch.setattr(shards.Shard, "packed", whole)
    rendered, real = [], Capture.optical_image
    monkeypatch.setattr(Capture, "optical_image", lambda self, **how: rendered.append(1) or real(self, **how))
    assert dataset(MADE_OF, tmp_path, workers=0).made == 4
    assert 0 < len(rendered) < 4  # of four scenes, those whose captures were not asked for yet
    for name in ("train-00000.tar", "train-00001.tar", "test-00000.tar", "manifest.csv"):
        for path in made.folder.glob(name):
            assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_the_noise_is_as_stated(tmp_path):
    """Of a grey wedge without fixed patterns: the variance of codes against their mean gives back both numbers."""
    study = {
        "scene": "grey-steps",
        "sensor": "mono-345",
        "set": {
            "region": {"rows": 400, "cols": 400}, "render.tolerance": 1e-2, "sensor.charge": None,
            "exposure.iso": 3200, "exposure.time_s": "auto",
        },
        "crops": {"rows": 400, "cols": 400},
        "splits": {"train": 1.0, "val": 0.0, "test": 0.0},
        "hold": ["noisy", "clean"],
    }  # fmt: skip
    dataset(study, tmp_path, workers=0)
    arrays, row = read_pair(tmp_path, 0)
    clean = arrays["clean"].astype(float) / row["electrons_per_dn"]
    off = arrays["noisy"].astype(float) - row["black_level_dn"] - clean
    used = clean < 0.8 * (row["white_level_dn"] - row["black_level_dn"])
    mean, square = clean[used], off[used] ** 2
    wanted = row["shot_dn"] * mean + row["read_dn2"]
    # A chi-square of one degree has twice its mean squared as variance.
    terms = np.stack([mean, np.ones_like(mean)], axis=1) / wanted[:, None]
    shot, read = np.linalg.lstsq(terms, square / wanted, rcond=None)[0]
    assert shot == pytest.approx(row["shot_dn"], rel=0.02)
    assert read == pytest.approx(row["read_dn2"], rel=0.1)


def test_fixed_patterns_and_dark_current_are_in_the_model_and_seeds_change_the_noise(tmp_path):
    """Of a bright flat field: what is off from frame to frame has one variance, what stays the other."""
    study = {
        "scene": "flat-field",
        "sensor": "mono-345",
        "set": {
            "region": {"rows": 150, "cols": 150}, "render.tolerance": 1e-2, "exposure.time_s": "auto",
            "light": {"line_nm": 550, "irradiance_w_per_m2": 0.025},  # seconds, for the dark current to gather
            "sensor.charge.prnu": 0.02, "sensor.charge.dsnu_e": 20, "sensor.charge.dark_current_e_per_s": 50,
        },
        "vary": {"noise.seed": [1, 2]},
        "crops": {"rows": 150, "cols": 150},
        "splits": {"train": 1.0, "val": 0.0, "test": 0.0},
        "hold": ["noisy", "clean"],
    }  # fmt: skip
    dataset(study, tmp_path, workers=0)
    (one, row), (two, _) = read_pair(tmp_path, 0), read_pair(tmp_path, 1)
    mean = float(one["clean"].mean()) / row["electrons_per_dn"]
    first, second = (part["noisy"].astype(float) - row["black_level_dn"] - mean for part in (one, two))
    assert row["dark_dn"] > 5.0 * row["read_dn2"] ** 0.5
    assert first.mean() == pytest.approx(row["dark_dn"], abs=0.05 * row["dark_dn"])
    # A sample's variance of 22500 is known to 1 %, one that is a difference of two to a few.
    temporal = row["shot_dn"] * (mean + row["dark_dn"]) + row["read_dn2"]
    assert np.var(first - second) / 2.0 == pytest.approx(temporal, rel=0.04)
    fixed = (row["prnu"] * mean) ** 2 + row["dsnu_dn"] ** 2
    assert np.mean((first - first.mean()) * (second - second.mean())) == pytest.approx(fixed, rel=0.06)


def test_two_data_sets_of_other_seeds_share_no_noise(tmp_path):
    made_of = {**MADE_OF, "scene": "flat-field", "vary": {}, "splits": {"train": 1.0, "val": 0.0, "test": 0.0}}
    rows = [dataset({**made_of, "seed": seed}, tmp_path / str(seed), workers=0).rows[0] for seed in (0, 1)]
    assert rows[0]["seed"] != rows[1]["seed"]


def test_a_card_without_licence_says_so_and_one_line_of_light_is_noted(tmp_path):
    made_of = {**MADE_OF, "scene": "siemens-star", "vary": {}, "splits": {"train": 1.0, "val": 0.0, "test": 0.0}}
    done = dataset(made_of, tmp_path, workers=0)
    assert "Licence of the data set: not stated" in (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "license" not in json.loads((tmp_path / "croissant.json").read_text(encoding="utf-8"))
    assert "a colour sensor in light of one line at 550 nm" in done.rows[0]["message"]
    expected = forecast_dataset(made_of, folder=tmp_path)
    assert (expected.captures, expected.found, expected.files) == (0, 1, 0)
    expected = forecast_dataset(made_of)
    assert (expected.captures, expected.found, expected.files) == (1, 0, 3)
    assert expected.disk_bytes == 3 * 80 * (2 + 4 + 3 * 4)


def test_keys_that_some_scenes_do_not_know_name_them():
    made_of = {**MADE_OF, "scene": ["leaves-in-colour", "flat-field"], "splits": {"train": 1, "val": 0, "test": 0}}
    with pytest.raises(ConfigError, match=r"vary\.scene\.shapes\.0\.seed: in flat-field: ") as caught:
        check_dataset({**made_of, "vary": {"scene.shapes.0.seed": {"integers": [1, 9]}}, "draws": 2})
    assert "leaves-in-colour" not in str(caught.value)
    with pytest.raises(ConfigError, match=r"set\.exposure\.is: unknown key"):
        check_dataset({**made_of, "set": {"exposure.is": 3}})
    check_dataset(made_of)


@pytest.mark.parametrize(("keys", "why"), rows("wrong-contents.txt", "datasets"))
def test_what_is_wrong_is_said_before_anything_is_made(keys, why, tmp_path):
    with pytest.raises((ConfigError, CamsimError)) as caught:
        dataset({**MADE_OF, **eval(keys)}, tmp_path / "out", workers=0)
    assert why in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_folder_without_a_data_set_is_said(tmp_path):
    with pytest.raises(InputError, match=r"holds no data set: there is no manifest\.parquet"):
        read_pair(tmp_path, 0)
