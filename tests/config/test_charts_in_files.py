"""Charts and drawings in scene files: the same shapes as in Python, and every fault at its place."""

import re

import pytest

import camsim
from camsim.api import load
from camsim.core.errors import ConfigError

HEAD = """\
camsim: scene/1
sensor: mono-345
lens: {kind: airy, f_number: 8}
light: {line_nm: 550, illuminance_lux: 1000}
exposure: {time_s: 0.01, iso: 100}
region: {rows: 8, cols: 8}
scene:
  unit: um
  background: {reflectance: 0.5}
  shapes:
"""
DRAWING = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><rect width="5" height="4" fill="navy"/></svg>'


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """Load a scene of one line."""
    (tmp_path / "drawing.svg").write_text(DRAWING)
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path / "sub")

    def read(line):
        (tmp_path / "scene.yaml").write_text(HEAD + f"    - {line}\n")
        return load(tmp_path / "scene.yaml").scene.shapes[0]

    return read


def test_a_chart_is_that_of_python(scene):
    line = "{kind: chart, name: slanted-edges, side: 9, cols: 3, angles_deg: [3, 8], dark: [black 2, 0.3], light: cyan}"
    assert scene(line) == camsim.charts.slanted_edges(
        side_um=9,
        cols=3,
        angles_deg=[3, 8],
        dark=[camsim.reflectance("black 2"), 0.3],
        light=camsim.reflectance("cyan"),
    )


def test_a_chart_may_stand_in_a_group(scene):
    group = scene("{kind: group, turn_deg: 30, shapes: [{kind: chart, name: dot-grid, spacing: 9, radius: 2}]}")
    assert group.shapes == (camsim.charts.dot_grid(spacing_um=9, radius_um=2),)


def test_a_drawing_is_that_of_python(scene):
    line = "{kind: svg, file: drawing.svg, width: 18, centre: [3, 4], rotate_deg: 5, palette: {NAVY: blue}}"
    palette = {"navy": camsim.reflectance("blue")}
    assert scene(line) == camsim.read_svg(
        "../drawing.svg", width_um=18, centre_um=(3, 4), rotate_deg=5, palette=palette
    )


@pytest.mark.parametrize(
    ("line", "faults"),
    [
        (
            "{kind: chart, name: siemens-stra, radius: 9}",
            ["11:27: scene.shapes.0.name: must be .* or zone-plate, not 'siemens-stra'; did you mean 'siemens-star'"],
        ),
        ("{kind: chart, radius: 9}", ["11:7: scene.shapes.0.name: missing; bars, "]),
        (
            "{kind: chart, name: siemens-star, radius: 0, cyles: 9, dark: blak 2}",
            [
                "11:49: scene.shapes.0.radius: must be a number above 0, not 0 .of the star; the card's is 5 % larger, "
                "in the scene's unit.",
                "11:52: scene.shapes.0.cyles: unknown key; did you mean 'cycles'",
                "11:68: scene.shapes.0.dark: unknown reflectance 'blak 2'; did you mean 'black 2'",
            ],
        ),
        (
            "{kind: chart, name: siemens-star, radius: 5, inner_radius: 7}",
            ["11:66: scene.shapes.0.inner_radius: is 7; it must be below 5$"],
        ),
        ("{kind: chart, name: qr, width: 9}", ["11:7: scene.shapes.0.text: missing; a word"]),
        ("{kind: chart, name: dot-grid, spacing: 9, radius: 2, rows: 1e5, cols: 100000}", ["rows: must be a whole"]),
        (
            "{kind: chart, name: dot-grid, spacing: 9, radius: 2, rows: 100000, cols: 100000}",
            ["11:66: scene.shapes.0.rows: makes 1e.10 shapes; a chart has at most 1000000"],
        ),
        ("{kind: svg, file: drawing.svg}", ["11:7: scene.shapes.0.width: missing; give width or height"]),
        ("{kind: svg, file: drawing.svg, width: 1, height: 2}", ["scene.shapes.0.height: given together with 'width'"]),
        ("{kind: svg, file: other.svg, width: 1}", ["11:25: scene.shapes.0.file: no such file: '.*other.svg'"]),
        ("{kind: svg, file: /etc/passwd, width: 1}", ["scene.shapes.0.file: '/etc/passwd' lies outside this file's"]),
        ("{kind: svg, file: ../drawing.svg, width: 1}", ["lies outside this file's folder; put it there"]),
        ("{kind: svg, file: scene.yaml, width: 1}", ["scene.yaml:1:1: is no XML: syntax error"]),
        (
            "{kind: svg, file: drawing.svg, width: 1, palette: {navy: bleu, red: 2}}",
            [
                "11:64: scene.shapes.0.palette.navy: unknown reflectance 'bleu'; did you mean 'blue'",
                "11:75: scene.shapes.0.palette.red: must be a number from 0 to 1",
            ],
        ),
    ],
)
def test_faults(scene, line, faults):
    with pytest.raises(ConfigError) as found:
        scene(line)
    said = str(found.value).splitlines()
    assert len(said) == len(faults), said
    for fault, message in zip(faults, said, strict=True):
        assert re.search(fault, message), message
