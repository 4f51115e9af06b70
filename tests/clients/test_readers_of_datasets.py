"""Other programs' readers over a data set: webdataset its shards, mlcroissant its card."""

import itertools
import json
import re

import numpy as np
import pytest

from camsim.study import dataset, read_pair

pytestmark = pytest.mark.clients

MADE_OF = {
    "scene": ["slanted-edge", "flat-field", "grey-steps"],
    "set": {"region": {"rows": 24, "cols": 24}, "render.tolerance": 1e-2},
    "vary": {"exposure.iso": [200, 800]},
    "crops": {"rows": 8, "cols": 8, "each": 2},
    "licence": "CC-BY-4.0",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("read")
    dataset(MADE_OF, place, workers=0)
    return place


@pytest.mark.filterwarnings("ignore")  # the readers' own
def test_webdataset_reads_every_sample(folder):
    import webdataset

    urls = sorted(str(path) for path in folder.glob("*.tar"))
    found = {}
    for sample in webdataset.WebDataset(urls, shardshuffle=False).decode():
        found[int(sample["__key__"])] = sample
    assert sorted(found) == list(range(12))
    for index, sample in found.items():
        arrays, row = read_pair(folder, index)
        for part in ("noisy", "clean", "truth"):
            np.testing.assert_array_equal(sample[f"{part}.npy"], arrays[part])
        assert sample["json"]["electrons_per_dn"] == row["electrons_per_dn"]


@pytest.mark.filterwarnings("ignore")
def test_the_patterns_of_the_card_are_all_shards_of_a_split(tmp_path):
    import webdataset

    made = dataset({**MADE_OF, "samples_per_shard": 3, "splits": {"train": 0.6, "val": 0.2, "test": 0.2}}, tmp_path)
    patterns = re.findall(r"`((\w+)-\S+\.tar)`, (\d+) samples", (tmp_path / "README.md").read_text(encoding="utf-8"))
    assert [split for _, split, _ in patterns] == ["train", "val", "test"]
    found = {}
    for pattern, split, count in patterns:
        keys = [s["__key__"] for s in webdataset.WebDataset(str(tmp_path / pattern), shardshuffle=False)]
        assert len(keys) == int(count)
        found |= dict.fromkeys(keys, split)
    assert found == {row["key"]: row["split"] for row in made.rows}
    assert any("{" in pattern for pattern, _, _ in patterns)


@pytest.mark.filterwarnings("ignore")
def test_the_card_is_valid_croissant(folder):
    import mlcroissant

    said = mlcroissant.Dataset(jsonld=str(folder / "croissant.json"))
    assert not said.metadata.ctx.issues.errors
    rows = list(itertools.islice(said.records("samples"), 3))
    assert [row["samples/index"] for row in rows] == [0, 1, 2]
    assert json.loads((folder / "croissant.json").read_text(encoding="utf-8"))["license"] == "CC-BY-4.0"
