"""From YAML to stages: units, defaults and what fits."""

from __future__ import annotations

import types
from collections.abc import Callable
from pathlib import Path

import pytest

import camsim
from camsim.api import load, load_camera
from camsim.core import memory
from camsim.core.errors import ConfigError
from camsim.optics import Airy, FourSpotOlpf, SquarePhotosite
from camsim.scene import Disc, Polygon, Rectangle
from camsim.sensor.adc import Adc
from camsim.sensor.cfa import Cfa
from camsim.sensor.exposure import Exposure
from camsim.spectra.curve import Curve
from camsim.spectra.light import Light
from camsim.spectra.named import reflectance, sensitivities


@pytest.mark.usefixtures("folder")
def test_every_value_of_the_good_files_arrives() -> None:
    setup = load("good.yaml")
    camera = setup.camera
    assert (camera.name, camera.serial, camera.rows, camera.cols, camera.pitch_um) == (
        "Mine",
        7,
        200,
        300,
        4.0,
    )
    assert camera.lens == Airy(f_number=8.0)
    assert camera.olpf == FourSpotOlpf(split_um=3.0)
    assert camera.photosite.side_um == pytest.approx(3.6, rel=1e-15)
    assert camera.cfa == Cfa(("GR", "BG"))
    assert dict(camera.quantum_efficiency.curves) == sensitivities("Nikon 5100 (NPL)")
    assert (camera.quantum_efficiency.per, camera.quantum_efficiency.peak) == ("energy", 0.5)
    assert (camera.full_well, camera.dark_current) == (camsim.FullWell(20000.0), camsim.DarkCurrent(1.5))
    assert (camera.prnu, camera.dsnu, camera.read_noise) == (camsim.Prnu(0.01), camsim.Dsnu(0.5), camsim.ReadNoise(3.0))
    assert camera.adc == Adc(bit_depth=12, black_level_dn=100, electrons_per_dn=5.0, base_iso=100.0)
    assert setup.light == Light("D55", illuminance_lux=5000.0)
    assert setup.exposure == Exposure(time_s=0.01, iso=200.0)
    assert setup.region is not None
    assert (setup.region.rows, setup.region.cols, setup.region.origin) == (20, 24, None)
    assert (setup.tolerance, setup.noise, setup.seed, setup.scene_name) == (1e-3, True, 1, "good")


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(("unit", "um"), [("pixel", 4.0), ("um", 1.0), ("mm", 1000.0)])
def test_lengths_are_in_the_scenes_unit(unit: str, um: float) -> None:
    scene = load("good.yaml", overrides=[f"scene.unit={unit}"]).scene
    assert scene.background == 0.9
    assert scene.shapes == (
        Rectangle(width_um=5 * um, height_um=4 * um, centre_um=(um, 2 * um), rotate_deg=4.0, reflectance=0.05),
        Polygon(points_um=((0, 0), (4 * um, 0), (0, 4 * um)), reflectance=reflectance("dark skin")),
        Disc(radius_um=3 * um, reflectance=Curve((400.0, 700.0), (0.1, 0.8), outside="hold")),
    )


@pytest.mark.usefixtures("folder")
def test_what_is_left_out_of_a_sensor_is_no_stage() -> None:
    keys = ("olpf", "charge", "photosite", "readout.read_noise_e")
    camera = load("good.yaml", overrides=[f"sensor.{key}=null" for key in keys]).camera
    left = (camera.olpf, camera.full_well, camera.dark_current, camera.prnu, camera.dsnu, camera.read_noise)
    assert left == (None,) * 6
    assert camera.photosite == SquarePhotosite(side_um=4.0)


@pytest.mark.usefixtures("folder")
def test_curves_of_ones_own() -> None:
    table = "{wavelength_nm: [400, 700], values: [1, 2]}"
    camera = load_camera(
        "my.yaml",
        lens=Airy(f_number=2.0),
        overrides=["sensor.cfa={kind: mono}", f"sensor.quantum_efficiency.curves={{Y: {table}}}"],
    )
    assert camera.cfa == Cfa.mono()
    assert camera.quantum_efficiency.curves == (("Y", Curve((400.0, 700.0), (1.0, 2.0))),)
    assert camera.lens == Airy(f_number=2.0)


def test_a_sensor_alone_has_no_keys_of_a_scene() -> None:
    with pytest.raises(ConfigError, match=r"--set exposure\.iso: a sensor without a scene has no such key"):
        load_camera("mono-345", lens=Airy(f_number=2.0), overrides=["exposure.iso=800"])


@pytest.mark.usefixtures("folder")
def test_the_lens_may_have_a_curve() -> None:
    overrides = ["lens.transmission={wavelength_nm: [400, 700], values: [0.9, 0.8]}"]
    assert load("good.yaml", overrides=overrides).camera.lens.transmission == Curve(
        (400.0, 700.0), (0.9, 0.8), outside="hold"
    )


def test_a_frame_that_does_not_fit_in_memory(edited: Callable[..., None], folder: Path) -> None:
    edited("rows: 200, cols: 300", "rows: 3000000, cols: 4000000", sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=["region=null"])
    assert str(caught.value).startswith(
        "my.yaml:4:8: frame: 3000000 × 4000000 photosites need about 480 TB of memory, "
    )
    assert str(caught.value).endswith(" are free; capture a region of it")
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=["region.rows=1000000", "region.cols=2000000"])
    assert "good.yaml:6:9: region: 1000000 × 2000000 photosites need about 80 TB" in str(caught.value)
    assert str(caught.value).endswith(" are free; make the region smaller")


def test_a_frame_that_passes_through_takes_more_the_larger_it_is_and_less_than_one_that_is_held() -> None:
    small, large = (memory.needed_bytes(rows, 9000, 3, ("mosaic",), held=False) for rows in (6000, 12_000))
    assert small > 1e8  # a band
    assert 0 < large - small < 0.01 * memory.needed_bytes(6000, 9000, 3, ("mosaic",))


def test_every_product_takes_memory() -> None:
    held = {name: memory.needed_bytes(1000, 2000, 3, ("mosaic", name)) for name in ("mosaic", "truth", "preview")}
    # Four bytes a channel of truth; the preview's own planes besides.
    assert held["truth"] >= held["mosaic"] + 2e6 * 3 * 4
    assert held["preview"] >= held["mosaic"] + 2e6 * 3 * 4
    assert memory.needed_bytes(2000, 1000, 3, ("mosaic", "truth")) == held["truth"]  # a frame on its side


def test_what_a_limit_leaves_is_what_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    files = {
        "/sys/fs/cgroup/memory.max": "3000000\n",
        "/sys/fs/cgroup/memory.current": "1000000\n",
    }
    machine = types.SimpleNamespace(available=4_096_000)
    monkeypatch.setattr(memory, "_text", lambda path: files.get(path, ""))
    monkeypatch.setattr(memory.psutil, "virtual_memory", lambda: machine)
    assert memory.available_bytes() == 2_000_000
    files["/sys/fs/cgroup/memory.max"] = "max\n"
    assert memory.available_bytes() == 4_096_000
    # The first version of control groups keeps them elsewhere.
    del files["/sys/fs/cgroup/memory.max"]
    files["/sys/fs/cgroup/memory/memory.limit_in_bytes"] = "5000000\n"
    files["/sys/fs/cgroup/memory/memory.usage_in_bytes"] = "2000000\n"
    assert memory.available_bytes() == 3_000_000
    monkeypatch.undo()
    assert memory.available_bytes() > 2**20


def test_what_a_limit_on_addresses_leaves_is_what_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    resource = pytest.importorskip("resource", reason="Windows has no such limits")
    taken = types.SimpleNamespace(memory_info=lambda: types.SimpleNamespace(vms=1_000_000))
    monkeypatch.setattr(memory.psutil, "Process", lambda: taken)
    for soft, left in ((2_500_000, 1_500_000), (900_000, 0)):
        monkeypatch.setattr(resource, "getrlimit", lambda which, soft=soft: (soft, resource.RLIM_INFINITY))
        assert memory.available_bytes() == left
