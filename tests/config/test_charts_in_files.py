"""Charts and drawings in scene files: the same shapes as in Python."""

import pytest

import camsim
from camsim.api import load
from camsim.errors import ConfigError

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


def test_a_drawing_that_is_none_is_told_at_its_own_line(scene):
    with pytest.raises(ConfigError, match=r"scene\.yaml:1:1: is no XML: syntax error"):
        scene("{kind: svg, file: scene.yaml, width: 1}")
