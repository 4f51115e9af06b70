"""``camsim capture --pairs``: what the index says is in the files, and belongs together."""

import csv
import json
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import tifffile
from tolerances import STATISTICAL

from camsim.files.reading import read_file

from .conftest import Run


def rows_of(folder: Path) -> list[dict[str, object]]:
    rows = json.loads((folder / "index.json").read_text())
    with (folder / "index.csv").open(newline="") as file:
        assert [{key: str(value) for key, value in row.items()} for row in rows] == list(csv.DictReader(file))
    return rows


def truth_of(path: Path) -> np.ndarray:
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack([channels[name].pixels for name in "RGB"], axis=2)


def test_pairs_belong_together(folder: Path, camsim: Run) -> None:
    done = camsim("capture", "small.yaml", "--pairs", "out", "--levels", "1,0.25")
    assert done.returncode == 0, done.stderr
    rows = rows_of(folder / "out")
    # Four phases, then three windows shifted by one, at two levels each.
    assert [row["cfa"] for row in rows[::2]] == ["RG/GB", "GR/BG", "GB/RG", "BG/GR", "GR/BG", "GB/RG", "BG/GR"]
    assert {(row["origin_row"] % 2, row["origin_col"] % 2) for row in rows} == {(0, 0), (0, 1), (1, 0), (1, 1)}
    assert len({row["seed"] for row in rows}) == 14
    assert sorted(path.name for path in (folder / "out").iterdir()) == sorted(
        [
            "README.md",
            "index.csv",
            "index.json",
            *(str(row[key]) for row in rows for key in ("noisy", "clean", "truth")),
        ]
    )
    # Names hold the phase in plain letters, and README.md the unit of every column.
    stems = [str(row["noisy"]).removesuffix("-noisy.dng")[4:] for row in rows[::2]]
    assert stems == [
        *("RGGB-x1", "GRBG-x1", "GBRG-x1", "BGGR-x1"),
        *("GRBG-from-col1-x1", "GBRG-from-row1-x1", "BGGR-from-row1-col1-x1"),
    ]
    page = (folder / "out" / "README.md").read_text(encoding="utf-8")
    for row in rows:
        assert str(row["cfa"]).replace("/", "") in str(row["noisy"])
    for column, unit in {**dict.fromkeys(rows[0], ""), "black_level_dn": "DN", "electrons_per_dn": "e⁻/DN"}.items():
        assert f"| `{column}` | {unit}" in page, column
    for row in rows:
        noisy, clean = (tifffile.imread(folder / "out" / str(row[key])).astype(float) for key in ("noisy", "clean"))
        truth = truth_of(folder / "out" / str(row["truth"]))
        letters = str(row["cfa"]).split("/")
        index = np.array([["RGB".index(letters[r % 2][c % 2]) for c in range(20)] for r in range(16)])
        one = np.take_along_axis(truth, index[:, :, None], axis=2)[:, :, 0]
        expected = np.minimum(row["black_level_dn"] + one / row["electrons_per_dn"], 4095)
        # A clean mosaic is the truth's own channel, rounded.
        assert np.abs(clean - expected).max() <= 0.5 + 1e-3
        # 9 e⁻ of read noise are 0.9 DN; the noise is there and its mean is not.
        assert 0.5 < (noisy - clean).std() < 8
        assert abs((noisy - clean).mean()) < STATISTICAL * (noisy - clean).std() / np.sqrt(noisy.size) + 0.2
        assert read_file(folder / "out" / str(row["noisy"])).record.description_sha256 == row["description_sha256"]
    still, shifted = (truth_of(folder / "out" / str(rows[k]["truth"])) for k in (0, -2))
    np.testing.assert_allclose(still[1:, 1:], shifted[:-1, :-1], atol=2e-4 * still.max())
    again = camsim("recapture", f"out/{rows[-1]['noisy']}", "--force")
    assert "the same bytes as" in again.stderr
    for bright, dim in zip(rows[::2], rows[1::2], strict=True):
        assert (bright["level"], dim["level"]) == (1, 0.25)
        np.testing.assert_allclose(
            truth_of(folder / "out" / str(bright["truth"])) / 4, truth_of(folder / "out" / str(dim["truth"])), rtol=1e-5
        )


def test_names_say_what_a_window_at_an_odd_place_shows(folder: Path, camsim: Run) -> None:
    """The array was named that begins at the frame's own corner: BG/GR of the window was called RGGB."""
    odd = "region.origin=[901, 1203]"
    done = camsim("capture", "small.yaml", "--pairs", "out", "--levels", "1", "--set", odd, "-q")
    assert done.returncode == 0, done.stderr
    rows = rows_of(folder / "out")
    assert {str(row["cfa"]) for row in rows[:4]} == {"RG/GB", "GR/BG", "GB/RG", "BG/GR"}
    for row in rows:
        assert str(row["noisy"])[4:8] == str(row["cfa"]).replace("/", "")


STAR = """
camsim: scene/1
sensor: d40-like
lens: {kind: gaussian, f_number: 4, sigma_um: 4}
light: {illuminant: D55, illuminance_lux: 1}
exposure: {time_s: 0.04, iso: 200}
region: {rows: 25, cols: 25, origin: [988, 1492]}
scene:
  unit: pixel
  background: {reflectance: 0.0}
  shapes: [{kind: point-source, electrons: 20000, centre: [0.5, 0.5]}]
render: {tolerance: 1.0e-4}
"""


def test_a_points_electrons_are_the_same_at_every_level(folder: Path, camsim: Run) -> None:
    """All levels had the image of the first, in which the point was as bright as that exposure makes it."""
    (folder / "star.yaml").write_text(STAR, encoding="utf-8")
    done = camsim("capture", "star.yaml", "--pairs", "out", "--levels", "1,0.25,4", "-q")
    assert done.returncode == 0, done.stderr
    for row in rows_of(folder / "out")[:3]:
        collected = truth_of(folder / "out" / str(row["truth"])).sum(axis=(0, 1))
        assert collected.max() == pytest.approx(20000.0, rel=1e-3), row["level"]


def test_the_largest_seed_is_the_last_pairs(folder: Path, camsim: Run) -> None:
    small = ("--set", "region={rows: 2, cols: 2}", "--set", f"noise.seed={2**63 - 7}")
    assert camsim("capture", "small.yaml", "--pairs", "out", "--levels", "1", *small).returncode == 0
    assert rows_of(folder / "out")[-1]["seed"] == 2**63 - 1
