"""``camsim info`` and ``camsim recapture`` as a user meets them."""

import hashlib
import json
import re
from pathlib import Path

import numpy as np
import tifffile
import yaml
from PIL import Image, PngImagePlugin

from .conftest import Run

FILES = ("a.dng", "a.exr", "e.exr:electrons", "a.tiff", "a.png", "m.png:mosaic")


def take(camsim: Run, *files: str) -> None:
    outputs = [word for file in files for word in ("-o", file)]
    changes = ("--set", "exposure.iso=800", "--set", "region.origin=[901, 1200]", "--seed", "9")
    taken = camsim("capture", "small.yaml", *changes, "-q", *outputs)
    assert taken.returncode == 0, taken.stderr


def test_recapture_gives_the_same_bytes(folder: Path, camsim: Run) -> None:
    take(camsim, *FILES)
    (folder / "small.yaml").unlink()
    for file in FILES:
        name = file.partition(":")[0]
        stem, suffix = name.split(".")
        again = camsim("recapture", name)
        assert again.returncode == 0, again.stderr
        assert again.stderr == f"{stem}-again.{suffix}: the same bytes as {name}\n"
        assert (folder / f"{stem}-again.{suffix}").read_bytes() == (folder / name).read_bytes()


def test_the_truth_of_a_dng_from_the_dng_alone(folder: Path, camsim: Run) -> None:
    take(camsim, "a.dng", "a.exr")
    again = camsim("recapture", "a.dng", "-q", "-o", "truth.exr")
    assert (again.returncode, again.stderr, again.stdout) == (0, "", "")
    assert (folder / "truth.exr").read_bytes() == (folder / "a.exr").read_bytes()


def test_what_differs_is_named_and_only_what_was_changed_is_called_altered(folder: Path, camsim: Run) -> None:
    take(camsim, "a.dng", "a.tiff", "m.png:mosaic")
    whole = (folder / "a.dng").read_bytes()
    codes = tifffile.imread(folder / "a.tiff")
    at = whole.index(codes.astype("<u2").tobytes())
    (folder / "a.dng").write_bytes(whole[:at] + (codes.ravel()[:1] ^ 8).astype("<u2").tobytes() + whole[at + 2 :])
    said = camsim("recapture", "a.dng").stderr
    assert f"differs from a.dng in 1 of 320 numbers of codes, by up to 8 of {codes.max()} (an altered file: " in said

    # As if another processor had found an error with other last bits, or one code of another.
    with tifffile.TiffFile(folder / "a.tiff") as tiff:
        record = tiff.pages[0].tags[270].value
    sum_of = re.compile(r',"sha256":"[0-9a-f]{64}"')
    other = sum_of.sub("", re.sub(r'"error_estimate":[^,]*', '"error_estimate":1.7e-09', record))
    digest = hashlib.sha256(other.encode()).hexdigest()
    other = other.replace(',"software":', f',"sha256":"{digest}","software":')
    for name, image, text, differs in (
        ("record.tiff", codes, other, "its record (error_estimate)"),
        ("packed.tiff", codes, record, "what goes with the same numbers and record: tags, or how they are packed"),
        (
            "codes.tiff",
            codes + (np.arange(20) == 3).astype(np.uint16),
            record,
            "16 of 320 numbers of codes, by up to 1 of",
        ),
    ):
        compression = "deflate" if name == "packed.tiff" else None
        tifffile.imwrite(folder / name, image, description=text, metadata=None, compression=compression)
        said = camsim("recapture", name).stderr
        assert f"differs from {name} in {differs}" in said
        assert "(another processor, or another version of a library" in said
        assert "altered" not in said


def test_info_is_short_unless_told(camsim: Run) -> None:
    take(camsim, "a.dng", "a.exr")
    short = camsim("info", "a.dng")
    assert short.returncode == 0, short.stderr
    stated = dict(line.split("  ", 1) for line in short.stdout.splitlines() if "  " in line)
    assert len(short.stdout.splitlines()) < 22
    assert stated["scene"].strip() == "1 shape, background 0.9"
    assert stated["light"].strip() == "Light(at=scene, illuminance_lux=5000, line_nm=550)"
    assert stated["optics"].strip().startswith("Airy(f_number=8, transmission=1) → FourSpotOlpf(split_um=3.66) → ")
    assert stated["exposure"].strip().startswith("Exposure(datetime=2000-01-01 00:00:00, iso=800, time_s=0.01")
    assert (
        stated["window"].strip() == "Region(cols=20, origin=[901, 1200], rows=16) of 2000 × 3008 photosites of 4.88 µm"
    )
    assert stated["computed"].strip() == "tolerance 0.0001, method auto"
    said = camsim("info", "a.dng", "--full")
    assert said.returncode == 0, said.stderr
    figures, _, computed = said.stdout.partition("\n\n")
    assert "mosaic, 16 × 20" in figures
    assert "colour filters GB / RG" in figures
    tree = yaml.safe_load(computed)["computed"]
    assert tree["exposure"]["iso"] == 800
    assert tree["seed"] == 9
    assert tree["region"]["origin"] == [901, 1200]
    whole = json.loads(camsim("info", "--json", "a.exr").stdout)
    assert whole["product"] == "truth"
    assert whole["description"]["camera"]["lens"]["f_number"] == 8


def test_a_compressed_dng_is_compressed_again(folder: Path, camsim: Run) -> None:
    take(camsim, "plain.dng")
    changes = ("--set", "exposure.iso=800", "--set", "region.origin=[901, 1200]", "--seed", "9")
    packed = camsim("capture", "small.yaml", *changes, "-q", "--compress", "-o", "packed.dng", "-o", "packed.exr")
    assert (packed.returncode, packed.stderr) == (0, "")
    assert camsim("recapture", "packed.dng").stderr == "packed-again.dng: the same bytes as packed.dng\n"
    assert (folder / "packed.dng").read_bytes() != (folder / "plain.dng").read_bytes()


def test_what_another_program_cut_is_not_what_the_record_describes(folder: Path, camsim: Run) -> None:
    """A star three columns off its record had an MTF below 0 in place of 0.86, and filters began with the wrong one."""
    take(camsim, "a.tiff", "m.png:mosaic")
    with tifffile.TiffFile(folder / "a.tiff") as tiff:
        codes, record = tiff.asarray(), tiff.pages[0].tags[270].value
    for name, cut in (("cut.tiff", codes[1:, 3:]), ("turned.tiff", np.rot90(codes).copy())):
        tifffile.imwrite(folder / name, cut, description=record, metadata=None, photometric="minisblack")
    with Image.open(folder / "m.png") as image:
        text = PngImagePlugin.PngInfo()
        text.add_text("camsim", image.text["camsim"], zip=True)
        image.crop((0, 0, 20, 15)).save(folder / "cut.png", pnginfo=text)
    for name, size in (("cut.tiff", "15 × 17"), ("turned.tiff", "20 × 16"), ("cut.png", "15 × 20")):
        said = camsim("info", name).stdout
        assert "reproducible  no, its record describes 16 × 20 photosites\n" in said
        assert "but is not of this image" in said
        assert json.loads(camsim("info", name, "--json").stdout)["fits_record"] is False
        others = ("star", "texture", "moire", "colour", "distortion", "truth") if name == "cut.tiff" else ()
        for command in ("mtf", *others):
            refused = camsim("measure", command, name, *(("-o", "t.exr") if command == "truth" else ()))
            assert refused.returncode == 2
            assert f"its record describes 16 × 20 photosites and its image has {size}: another" in refused.stderr
            assert f"'{name}'" in refused.stderr
        assert f"its image has {size}" in camsim("recapture", name).stderr
    whole = json.loads(camsim("info", "a.tiff", "--json").stdout)
    assert whole["fits_record"] is True
