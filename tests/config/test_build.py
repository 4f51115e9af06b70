"""From YAML to stages: what is left out, samples in files, curves that must cover the light, and what fits."""

import types
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
import psutil
import pytest
import tifffile

import camsim
from camsim.api import load, load_camera
from camsim.core import memory
from camsim.errors import ConfigError


@pytest.mark.usefixtures("folder")
def test_what_is_left_out_of_a_sensor_is_no_stage() -> None:
    keys = ("olpf", "charge", "photosite", "readout.read_noise_e")
    camera = load("good.yaml", overrides=[f"sensor.{key}=null" for key in keys]).camera
    left = (camera.olpf, camera.full_well, camera.dark_current, camera.prnu, camera.dsnu, camera.read_noise)
    assert left == (None,) * 6
    assert camera.photosite == camsim.SquarePhotosite(side_um=4.0)


def test_a_sensor_alone_has_no_keys_of_a_scene() -> None:
    with pytest.raises(ConfigError, match=r"--set exposure\.iso: a sensor without a scene has no such key"):
        load_camera("mono-345", lens=camsim.Airy(f_number=2.0), overrides=["exposure.iso=800"])


@pytest.mark.parametrize("suffix", ["npy", "tiff", "exr"])
def test_a_pattern_from_a_file(folder: Path, edited: Callable[..., None], suffix: str) -> None:
    pattern = np.array([[0, 1, 0.5], [1, 4, 1], [0, 1, 0]], np.float32)
    np.save(folder / "psf.npy", pattern)
    tifffile.imwrite(folder / "psf.tiff", pattern)
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"Y": pattern}).write(str(folder / "psf.exr"))
    edited("{kind: airy, f_number: 8}", f"{{kind: measured-psf, f_number: 8, file: psf.{suffix}, spacing_um: 2}}")
    assert load("scene.yaml").camera.lens == camsim.MeasuredPsf(irradiance=pattern.astype(float), spacing_um=2.0)


def test_a_complex_transfer_from_a_file(folder: Path, edited: Callable[..., None]) -> None:
    ramp = np.zeros((5, 5), complex)
    ramp[1:4, 1:4] = np.outer(np.ones(3), [0.5 + 0.2j, 1.0, 0.5 - 0.2j])
    ramp[2, 2] = 1.0
    parts = {"re": ramp.real.astype(np.float32), "im": ramp.imag.astype(np.float32)}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, parts).write(str(folder / "otf.exr"))
    edited("{kind: airy, f_number: 8}", "{kind: measured-otf, f_number: 8, file: otf.exr, spacing_per_um: 0.1}")
    expected = camsim.MeasuredOtf(values=ramp, spacing_per_um=0.1)
    np.testing.assert_allclose(load("scene.yaml").camera.lens.values, expected.values, rtol=0, atol=1e-7)  # type: ignore[attr-defined]


def test_curves_must_cover_the_light(edited: Callable[..., None]) -> None:
    """D55 goes on from 700 nm to 830 nm, at about 72 (of 100 at 560 nm): 30 % of its photons."""
    curves = "{" + ", ".join(f"{c}: {{wavelength_nm: [300, 700], values: [1, 1]}}" for c in "RG")
    edited("Nikon 5100 (NPL)", curves + ", B: {wavelength_nm: [300, 700], values: [1, 1], outside: zero}}", sensor=True)
    with pytest.raises(ConfigError) as caught:
        load("good.yaml", overrides=["sensor.quantum_efficiency.per=photon"])
    first, second = str(caught.value).splitlines()
    assert first == (
        "my.yaml:9:15: quantum_efficiency.curves.R: 700..830 nm is missing, with 30 % of the photons of D55; "
        "extend the table, or say outside: zero (or hold)"
    )
    assert second.startswith("my.yaml:9:63: quantum_efficiency.curves.G: 700..830 nm is missing")
    # Behind an infrared cut nothing is missing any more.
    load("good.yaml", overrides=["light={line_nm: 550, illuminance_lux: 1}"])


@pytest.mark.usefixtures("folder")
def test_filters_must_cover_the_light() -> None:
    with pytest.raises(ConfigError, match=r"lens.filters.0: 300..400 nm is missing, with 3.9 % of the photons"):
        load("good.yaml", overrides=["lens.filters=[{wavelength_nm: [400, 830], values: [1, 1]}]"])


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
    monkeypatch.setattr(psutil, "virtual_memory", lambda: machine)
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
    monkeypatch.setattr(psutil, "Process", lambda: taken)
    for soft, left in ((2_500_000, 1_500_000), (900_000, 0)):
        monkeypatch.setattr(resource, "getrlimit", lambda which, soft=soft: (soft, resource.RLIM_INFINITY))
        assert memory.available_bytes() == left
