"""``camsim expose``: renders, cubes, photographs and arrays become raw files."""

import csv
import json
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR
import tifffile
from PIL import Image

from .conftest import Run

RANDOM = np.random.default_rng(11)


def done(camsim: Run, *arguments: str) -> subprocess.CompletedProcess[str]:
    ran = camsim("expose", *arguments)
    assert ran.returncode == 0, ran.stderr
    return ran


def codes(path: Path) -> np.ndarray:
    return np.asarray(tifffile.imread(path))


def test_electrons_become_codes_and_come_again(folder: Path, camsim: Run) -> None:
    electrons = np.linspace(0.0, 9000.0, 24 * 32).reshape(24, 32)
    np.save(folder / "mean.npy", electrons)
    out = ("-o", "shot.dng", "-o", "truth.exr", "-o", "all.npz")
    stated = done(camsim, "mean.npy", "--sensor", "mono-345", "--as", "electrons", "--seed", "3", *out)
    assert "optics       none: light as it lies on the photosites" in stated.stderr
    truth = OpenEXR.File(str(folder / "truth.exr"), separate_channels=True).channels()
    np.testing.assert_allclose(next(iter(truth.values())).pixels, electrons, rtol=1e-6)
    held = np.load(folder / "all.npz")
    assert np.array_equal(held["mosaic"], codes(folder / "shot.dng"))
    assert np.array_equal(held["truth"][..., 0], electrons.astype(np.float32))
    again = camsim("recapture", "shot.dng")
    assert again.stderr == "shot-again.dng: the same bytes as shot.dng\n"
    assert "reproducible  with the light mean.npy" in camsim("info", "shot.dng").stdout
    said = json.loads(camsim("info", "shot.dng", "--json").stdout)["description"]["image"]
    assert (said["source"], said["unit"], len(said["sha256"])) == ("mean.npy", "electrons", 64)


def test_recapture_needs_the_very_light(folder: Path, camsim: Run) -> None:
    Image.fromarray(RANDOM.integers(0, 256, (8, 8, 3), np.uint8)).save(folder / "photo.png")
    done(camsim, "photo.png", "--sensor", "d40-like")
    (folder / "photo.png").rename(folder / "other.png")
    gone = camsim("recapture", "photo.dng")
    assert gone.returncode == 2
    assert "not reproducible without the light 'photo.png'; put it there, or beside this file" in gone.stderr
    Image.fromarray(RANDOM.integers(0, 256, (8, 8, 3), np.uint8)).save(folder / "photo.png")
    other = camsim("recapture", "photo.dng")
    assert other.returncode == 2
    assert "is another one than was exposed, its samples differ" in other.stderr
    assert not (folder / "photo-again.dng").exists()


def test_a_render_is_light_of_any_brightness(folder: Path, camsim: Run) -> None:
    planes = {f"ViewLayer.Combined.{c}": RANDOM.random((8, 10), np.float32) * 4 for c in "RGB"}
    planes |= {"ViewLayer.Combined.A": np.ones((8, 10), np.float32), "ViewLayer.Depth.Z": np.ones((8, 10), np.float32)}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, planes).write(str(folder / "render.exr"))
    done(camsim, "render.exr", "--sensor", "d40-like", "--no-noise", "--time", "0.01", "--lux", "20")
    done(camsim, "render.exr", "--sensor", "d40-like", "--no-noise", "--time", "0.005", "--lux", "40", "-o", "same.dng")
    assert np.array_equal(codes(folder / "render.dng"), codes(folder / "same.dng"))


def test_cubes_and_photographs_in_one_command(folder: Path, camsim: Run) -> None:
    nodes_nm = np.arange(400.0, 701.0, 10.0)
    grey = np.full((6, 8, 31), 0.4, np.float32)
    np.savez(folder / "cube.npz", cube=grey, wavelength_nm=nodes_nm)
    np.save(folder / "bare.npy", grey)
    Image.fromarray(np.full((6, 8, 3), 170, np.uint8)).save(folder / "photo.jpg")
    how = ("--sensor", "d40-like", "--no-noise", "--iso", "400")
    done(camsim, "cube.npz", *how)
    done(camsim, "bare.npy", *how, "--as", "reflectance", "--wavelengths", "400:700:10")
    done(camsim, "photo.jpg", *how)
    assert np.array_equal(codes(folder / "cube.dng"), codes(folder / "bare.dng"))
    # sRGB's 170 of 255 is 0.402 of white.
    np.testing.assert_allclose(codes(folder / "photo.dng") - 128.0, (codes(folder / "cube.dng") - 128) * 1.0055, atol=1)


def test_a_folder_of_pictures_is_as_many_raw_files(folder: Path, camsim: Run) -> None:
    (folder / "frames").mkdir()
    (folder / "raw").mkdir()
    for number in range(12):
        Image.fromarray(np.full((4, 6), 20 * number + 9, np.uint8)).save(folder / "frames" / f"{number:02}.png")
    (folder / "frames" / "notes.txt").write_text("none of them", encoding="utf-8")
    stated = done(camsim, "frames", "--sensor", "d40-like", "-o", "raw/shot.dng", "--seed", "5")
    assert stated.stderr.splitlines()[0].endswith("00.png: raw/shot-00.dng")
    means = [codes(folder / "raw" / f"shot-{number:02}.dng").mean() for number in range(12)]
    assert len(list((folder / "raw").iterdir())) == 12
    assert means[-1] > means[6] > means[0] > 100.0
    again = camsim("expose", "frames", "--sensor", "d40-like", "-o", "raw/shot.dng")
    assert again.returncode == 2
    assert again.stderr.splitlines()[-1] == "… and 4 more"


ALONE = (
    "camsim: scene/1\nsensor: d40-like\nlens: none\nlight: {file: lights/render.exr}\n"
    "exposure: {iso: 400}\nnoise: {seed: 3}\n"
)


def renders(folder: Path, count: int = 1) -> None:
    (folder / "lights").mkdir()
    for number in range(count):
        light = np.random.default_rng(number).random((24, 36, 3), dtype=np.float32)
        channels = {name: light[..., k] for k, name in enumerate("RGB")}
        name = "render" if count == 1 else f"{number}"
        OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(folder / f"lights/{name}.exr"))


def test_a_file_without_a_lens_is_exposed_as_the_command_does(folder: Path, camsim: Run) -> None:
    renders(folder)
    (folder / "shot.yaml").write_text(ALONE, "utf-8")
    taken = camsim("capture", "shot.yaml", "-o", "a.dng", "-o", "a.exr")
    assert taken.returncode == 0, taken.stderr
    assert "optics       none: light as it lies on the photosites" in taken.stderr
    out = ("-o", "b.dng", "-o", "b.exr")
    done(camsim, "lights/render.exr", "--sensor", "d40-like", "--iso", "400", "--seed", "3", *out)
    assert (folder / "a.dng").read_bytes() == (folder / "b.dng").read_bytes()
    assert (folder / "a.exr").read_bytes() == (folder / "b.exr").read_bytes()
    assert camsim("recapture", "a.dng").stderr == "a-again.dng: the same bytes as a.dng\n"
    several = camsim("capture", "shot.yaml", "--frames", "2", "-o", "f.dng", "-q")
    assert several.returncode == 0, several.stderr
    assert (folder / "f-0.dng").read_bytes() == (folder / "a.dng").read_bytes()
    assert not np.array_equal(codes(folder / "f-0.dng"), codes(folder / "f-1.dng"))
    assert "light on a sensor, no faults" in camsim("validate", "shot.yaml").stdout


def test_what_is_wrong_with_light_alone_is_said_with_its_place(folder: Path, camsim: Run) -> None:
    renders(folder)
    Image.fromarray(np.zeros((4000, 9000, 3), np.uint8)).save(folder / "huge.png")
    for text, why in (
        (ALONE.replace("render.exr", "none.exr"), "shot.yaml:4:8: light: no such file"),
        (
            ALONE.replace("lights/render.exr", "../x.exr"),
            "shot.yaml:4:8: light: '../x.exr' lies outside this file's folder",
        ),
        (ALONE.replace("lights/render.exr", "huge.png"), "and the sensor has 2000 × 3008 photosites"),
        (ALONE.replace("render.exr}", "render.exr, unit: electron}"), "did you mean 'electrons'?"),
        (ALONE + "scene: {unit: pixel}\n", "shot.yaml:7:1: scene: unknown key"),
        (ALONE.replace("lens: none", "lens: nothing"), "shot.yaml:3"),
        (ALONE + "region: {rows: 8, cols: 8}\n", "is 8 × 8, and the light has 24 × 36 photosites"),
    ):
        (folder / "shot.yaml").write_text(text, "utf-8")
        ran = camsim("capture", "shot.yaml")
        assert ran.returncode == 2
        assert why in ran.stderr
        assert not (folder / "shot.dng").exists()
    (folder / "shot.yaml").write_text(ALONE, "utf-8")
    ran = camsim("explain", "shot.yaml")
    assert ran.returncode == 2
    assert ran.stderr.startswith("shot.yaml: lens: none, and this is of a scene that a lens shows")


def test_sweeps_and_data_sets_take_a_folder_of_light(folder: Path, camsim: Run) -> None:
    renders(folder, 5)
    study = (
        "camsim: study/1\nlight: lights/*.exr\nsensor: d40-like\nvary: {exposure.iso: [200, 800]}\n"
        "measure: [signal]\nfiles: '{index}.dng'\n"
    )
    (folder / "study.yaml").write_text(study, "utf-8")
    swept = camsim("sweep", "study.yaml", "-o", "out", "--workers", "0")
    assert swept.returncode == 0, swept.stderr
    rows = list(csv.DictReader((folder / "out/manifest.csv").read_text("utf-8").splitlines()))
    assert [(row["light_file"], row["exposure_iso"]) for row in rows[:3]] == [
        ("lights/0.exr", "200"), ("lights/0.exr", "800"), ("lights/1.exr", "200"),
    ]  # fmt: skip
    done(camsim, "lights/2.exr", "--sensor", "d40-like", "--iso", "200", "--seed", rows[4]["seed"], "-o", "two.dng")
    assert np.array_equal(codes(folder / "out/4.dng"), codes(folder / "two.dng"))
    again = camsim("sweep", "study.yaml", "-o", "out", "--workers", "0", "--json")
    assert json.loads(again.stdout)["found"] == 10
    made = (
        "camsim: dataset/1\nlight: lights/*.exr\nsensor: d40-like\nvary: {exposure.iso: {choice: [200, 1600]}}\n"
        "crops: {rows: 8, cols: 8, each: 2}\nsplits: {train: 0.6, val: 0.2, test: 0.2}\n"
    )
    (folder / "pairs.yaml").write_text(made, "utf-8")
    ran = camsim("dataset", "pairs.yaml", "-o", "set", "--workers", "0")
    assert ran.returncode == 0, ran.stderr
    rows = list(csv.DictReader((folder / "set/manifest.csv").read_text("utf-8").splitlines()))
    splits = {
        row["light_file"]: {other["split"] for other in rows if other["light_file"] == row["light_file"]}
        for row in rows
    }
    assert len(rows) == 10
    assert len(splits) == 5
    assert all(len(one) == 1 for one in splits.values())
    assert sorted(split for one in splits.values() for split in one) == ["test", "train", "train", "train", "val"]
    for text, why in (
        (made.replace("lights/*.exr", "none/*.exr"), "no file of '.' matches 'none/*.exr'"),
        (made.replace("sensor: d40-like\n", ""), "sensor: missing; without a scene"),
        (made.replace("light: lights/*.exr\n", ""), "scene: missing; name one, or a list, or files of light"),
    ):
        (folder / "bad.yaml").write_text(text, "utf-8")
        ran = camsim("validate", "bad.yaml")
        assert ran.returncode == 2
        assert why in ran.stderr, ran.stderr
