"""Shipped lenses by name, what a lens file's faults are called, and pictures of what a lens does over the frame."""

import pytest

import camsim
from camsim.api import load
from camsim.cli.explain_plot import draw
from camsim.cli.show import lines_of_list, text_of
from camsim.config import library

PNG = b"\x89PNG"
LENS = """\
camsim: lens/1
name: own
f_number: 4
wavelength_nm: [550]
height_um: [0, 9000]
zernike: [4]
waves: [[[0], [0.2]]]
"""


def test_shipped_lenses_are_listed_and_shown() -> None:
    names = [line.split()[0] for line in lines_of_list("lenses")]
    assert names == list(library.shipped("lens")) == ["cooke-triplet", "double-gauss", "mobile", "perfect"]
    displayed = text_of("double-gauss")
    assert displayed.startswith("# lenses/double-gauss.yaml\n")
    assert "#   image circle  49.34 mm" in displayed


def test_a_lens_file_lies_beside_its_scene(tmp_path) -> None:
    (tmp_path / "own.yaml").write_text(LENS, encoding="utf-8")
    scene = tmp_path / "scene.yaml"
    text = library.shipped("scene")["field-lens"].read_text(encoding="utf-8")
    scene.write_text(text.replace("file: double-gauss", "file: own.yaml, focus_um: 20"), encoding="utf-8")
    lens = load(scene).camera.lens
    assert lens == camsim.FieldLens(
        f_number=4, wavelength_nm=[550], height_um=[0, 9000], zernike=[4], waves=[[[0], [0.2]]], focus_um=20
    )
    (tmp_path / "own.yaml").write_text(LENS.replace("[0, 9000]", "[0, 0]"), encoding="utf-8")
    with pytest.raises(camsim.errors.ConfigError, match=r"own\.yaml:5:12: height_um: \[0\.0, 0\.0\]; must increase"):
        load(scene)
    (tmp_path / "own.yaml").write_text(LENS.replace("zernike:", "zernikes:"), encoding="utf-8")
    with pytest.raises(camsim.errors.ConfigError, match=r"own\.yaml:6:1: zernikes: unknown key"):
        load(scene)
    scene.write_text(text.replace("double-gauss", "double-gaus"), encoding="utf-8")
    with pytest.raises(camsim.errors.ConfigError, match="unknown lens 'double-gaus'; did you mean 'double-gauss'"):
        load(scene)


def test_what_a_lens_does_over_the_frame_is_drawn() -> None:
    capture = load("field-lens")
    assert draw(capture, "field", "plot.png").startswith(PNG)
    assert draw(capture, "psf", "plot.png", (-3300.0, -2700.0)).startswith(PNG)
    with pytest.raises(camsim.errors.CamsimError, match="lies 30000 µm from the axis; the lens's image circle ends at"):
        draw(capture, "psf", "plot.png", (30000.0, 0.0))
    with pytest.raises(camsim.errors.CamsimError, match="the lens is Airy, the same all over the frame"):
        draw(load("slanted-edge"), "field", "plot.png")
