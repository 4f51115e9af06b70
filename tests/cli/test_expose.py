"""``camsim expose`` in processes of their own: renders, cubes, photographs and arrays become raw files."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
import tifffile
from PIL import Image

Run = Callable[..., subprocess.CompletedProcess[str]]
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
    told = done(camsim, "mean.npy", "--sensor", "mono-345", "--as", "electrons", "--seed", "3", *out)
    assert "optics       none: light as it lies on the photosites" in told.stderr
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
    for number in range(100):
        Image.fromarray(np.full((4, 6), 2 * number + 9, np.uint8)).save(folder / "frames" / f"{number:03}.png")
    (folder / "frames" / "notes.txt").write_text("none of them", encoding="utf-8")
    told = done(camsim, "frames", "--sensor", "d40-like", "-o", "raw/shot.dng", "--seed", "5")
    assert told.stderr.splitlines()[0].endswith("000.png: raw/shot-000.dng")
    means = [codes(folder / "raw" / f"shot-{number:03}.dng").mean() for number in range(100)]
    assert len(list((folder / "raw").iterdir())) == 100
    assert means[-1] > means[50] > means[0] > 100.0
    again = camsim("expose", "frames", "--sensor", "d40-like", "-o", "raw/shot.dng")
    assert again.returncode == 2
    assert again.stderr.splitlines()[-1] == "… and 92 more"


def test_what_cannot_be_is_said_in_a_sentence_and_nothing_is_written(folder: Path, camsim: Run) -> None:
    np.save(folder / "mean.npy", np.ones((4, 4)))
    (folder / "none").mkdir()
    for arguments, said in (
        (("mean.npy",), "its numbers may be anything; give unit (--as): electrons, photons"),
        (("mean.npy", "--as", "electron"), "--as: unknown unit 'electron'; did you mean 'electrons'?"),
        (("mean.npy", "--as", "electrons", "--time", "auto"), "electrons say how much light there is; give seconds"),
        (
            ("mean.npy", "--as", "electrons", "--time", "1/50"),
            "--time: must be seconds or auto, not '1/50'; write 0.02",
        ),
        (("mean.npy", "--as", "photons", "--wavelengths", "400:700"), "--wavelengths: must be wavelengths in nm"),
        (("none",), "'none' holds no light"),
        (("gone.npy", "--as", "electrons"), "cannot read 'gone.npy': there is no such file"),
        (("mean.npy", "--as", "electrons", "-o", "t.exr"), "says nothing of the other channels"),
        (("mean.npy", "--as", "electrons", "--set", "exposure.iso=8"), "its own begin with 'sensor.'"),
    ):
        ran = camsim("expose", *arguments, "--sensor", "d40-like")
        assert ran.returncode == 2, arguments
        assert said in ran.stderr, ran.stderr
    assert {path.suffix for path in folder.iterdir() if path.is_file()} == {".npy", ".yaml"}
