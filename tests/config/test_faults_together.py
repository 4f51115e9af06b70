"""Whole files: none wrong, all wrong, nothing in them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from camsim.capture import load
from camsim.errors import ConfigError


def test_the_good_files_have_no_faults(folder: Path) -> None:
    assert load("good.yaml").name == "good"


@pytest.mark.parametrize("text", ["", "# nothing\n"])
def test_an_empty_file(folder: Path, text: str) -> None:
    (folder / "scene.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"the file is empty; begin it with 'camsim: scene/1'$"):
        load("scene.yaml")


@pytest.mark.parametrize("text", ["just words\n", "- 1\n", "3"])
def test_a_file_that_holds_no_table(folder: Path, text: str) -> None:
    (folder / "scene.yaml").write_text(text)
    wanted = "scene.yaml:1:1: must be a table of keys and values; begin it with 'camsim: scene/1'"
    with pytest.raises(ConfigError, match=f"^{re.escape(wanted)}$"):
        load("scene.yaml")


def test_all_faults_of_both_files_and_the_command_line_at_once(folder: Path) -> None:
    """Also what only the stages see (a crossing, unknown names) when the schema has faults of its own."""
    (folder / "scene.yaml").write_text(
        "camsim: scene/1\n"
        "sensor: my.yaml\n"
        "lens: {kind: airy, f_number: 8, transmission: {wavelength_nm: [500, 400], values: [1, 1]}}\n"
        "light: {illuminant: D99, illuminance_lux: 0}\n"
        "exposure: {time_s: &t 0.01, iso: 200}\n"
        "exposure: {}\n"
        "scene:\n"
        "  unit: pixel\n"
        "  background: {reflectance: drak skin}\n"
        "  shapes:\n"
        "    - {kind: polygon, points: [[0, 0], [1, 1], [1, 0], [0, 1]], reflectance: blue skky}\n"
        "    - {kind: disc, radius: -1, reflectance: 0}\n"
    )
    sensor = (folder / "my.yaml").read_text()
    (folder / "my.yaml").write_text(sensor.replace("(NPL)", "").replace("pitch_um: 4.0", "pitch_um: 0"))
    with pytest.raises(ConfigError) as caught:
        load("scene.yaml", overrides=["nonsense", "noise.seed=-1"], seed=-3)
    assert [(fault.file, fault.line, fault.column, fault.key) for fault in caught.value.faults] == [
        ("--set nonsense", 0, 0, ""),
        ("--seed", 0, 0, ""),
        ("--set noise.seed", 0, 0, ""),
        ("scene.yaml", 3, 47, "lens.transmission"),
        ("scene.yaml", 4, 21, "light.illuminant"),
        ("scene.yaml", 4, 43, "light.illuminance_lux"),
        ("scene.yaml", 5, 20, "exposure.time_s"),
        ("scene.yaml", 6, 1, "exposure"),
        ("scene.yaml", 9, 29, "scene.background.reflectance"),
        ("scene.yaml", 11, 31, "scene.shapes.0.points"),
        ("scene.yaml", 11, 78, "scene.shapes.0.reflectance"),
        ("scene.yaml", 12, 28, "scene.shapes.1.radius"),
        ("my.yaml", 4, 41, "frame.pitch_um"),
        ("my.yaml", 9, 11, "quantum_efficiency.curves"),
    ]
