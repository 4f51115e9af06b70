from collections.abc import Callable
from pathlib import Path

import pytest

SCENE = """\
camsim: scene/1
sensor: my.yaml
lens: {kind: airy, f_number: 8}
light: {illuminant: D55, illuminance_lux: 5000}
exposure: {time_s: 0.01, iso: 200}
region: {rows: 20, cols: 24}
scene:
  unit: pixel
  background: {reflectance: 0.9}
  shapes:
    - {kind: rectangle, width: 5, height: 4, centre: [1, 2], rotate_deg: 4, reflectance: 0.05}
    - kind: polygon
      points: [[0, 0], [4, 0], [0, 4]]
      reflectance: dark skin
    - {kind: disc, radius: 3, reflectance: {wavelength_nm: [400, 700], values: [0.1, 0.8]}}
render: {tolerance: 1e-3}
noise: {enabled: true, seed: 1}
"""

SENSOR = """\
camsim: sensor/1
name: Mine
serial: 7
frame: {rows: 200, cols: 300, pitch_um: 4.0}
photosite: {kind: square, fill_factor: 0.81}
olpf: {kind: four-spot, split_um: 3.0}
cfa: {kind: bayer, pattern: GRBG}
quantum_efficiency:
  curves: Nikon 5100 (NPL)
  per: energy
  peak: 0.5
charge: {full_well_e: 20000, dark_current_e_per_s: 1.5, prnu: 0.01, dsnu_e: 0.5}
readout: {bit_depth: 12, black_level_dn: 100, base_iso: 100, electrons_per_dn: 5.0, read_noise_e: 3.0}
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to stand in, with a good scene and its sensor."""
    (tmp_path / "good.yaml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "my.yaml").write_text(SENSOR, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def edited(folder: Path) -> Callable[..., None]:
    """Write ``scene.yaml`` (or the sensor, ``my.yaml``) with one piece of its good text replaced."""

    def edit(old: str, new: str, *, sensor: bool = False) -> None:
        text = SENSOR if sensor else SCENE
        assert text.count(old) == 1, f"{old!r} is {text.count(old)} times in the good file"
        name = "my.yaml" if sensor else "scene.yaml"
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")

    return edit
