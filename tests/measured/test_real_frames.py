"""Flats and darks as real cameras and programs store them, by NumPy alone: figures are those they were made of."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from maker_files import Tags, mosaic_tags, tiff_raw
from tolerances import STATISTICAL

from camsim.cli.app import app
from camsim.errors import InputError
from camsim.measure import read_picture
from camsim.measure.noise import ChannelNoise, measure_noise, read_shots
from tests.tables import rows

GAIN, READ_E, PRNU, DARK_E_PER_S = 0.2, 3.0, 0.006, 5.0
LEVELS = (400, 900, 1800, 3200, 5200, 7600, 9600, 12000, 14500)
LONG = {f"{number:03d}" for number in range(len(LEVELS) + 1, 999, len(LEVELS) + 2)}
"""Names of the darks of the second time."""

Save = Callable[[np.ndarray, Path], Path]


def npy(change: Callable[[np.ndarray], np.ndarray]) -> Save:
    def save(codes: np.ndarray, path: Path) -> Path:
        np.save(path.with_suffix(".npy"), change(codes))
        return path.with_suffix(".npy")

    return save


def flats_and_darks(
    place: Path,
    save: Save,
    *,
    side: int = 96,
    darks: tuple[float, ...] = (0.01, 1.0),
    shape: Any = 1.0,
    frames: int = 4,
    added: int = 1,
    say: bool = False,
    bend: float = 0.0,
) -> Path:
    """A folder with its index; ``added`` frames are summed to each, and the index says so."""
    rng = np.random.default_rng(5)
    response = (1.0 + PRNU * rng.standard_normal((side, side))) * shape
    offset = 2.0 * rng.standard_normal((side, side))

    def frame(light_e: float, time_s: float) -> np.ndarray:
        charge = rng.poisson(np.minimum(light_e * response + DARK_E_PER_S * time_s, 18_000.0))
        charge = charge * (1.0 - bend * charge / 18_000.0) + offset + READ_E * rng.standard_normal(charge.shape)
        return np.clip(np.rint(128.0 + GAIN * charge), 0, 4095).astype(np.int64)

    shots = [("flat", e, 0.01) for e in LEVELS] + [("dark", 0, time_s) for time_s in darks]
    rows = [("file", "kind", "exposure", "time_s", *(["summed"] if say else []))]
    for number, (kind, e, time_s) in enumerate(shots * frames):
        codes = np.sum([frame(e, time_s) for _ in range(added)], axis=0)
        rows.append((save(codes, place / f"{number:03d}").name, kind, e, time_s, *([added] if say else [])))
    with (place / "index.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    return place


def channels(place: Path, cfa: str = "mono") -> tuple[ChannelNoise, ...]:
    return measure_noise(read_shots(place, cfa=cfa)).channels


@pytest.mark.parametrize("stored", ["as they are", "12 bits in 16", "12 bits over all of 16"])
def test_rounding_is_that_of_the_step_between_codes(stored: str, tmp_path: Path) -> None:
    factor = {"as they are": 1.0, "12 bits in 16": 16.0, "12 bits over all of 16": 65535 / 4095}[stored]
    save = npy(lambda codes: np.rint(codes * factor).astype(np.uint16))
    (channel,) = channels(flats_and_darks(tmp_path, save))
    read, gain = channel.transfer.read_noise_e, channel.transfer.gain_dn_per_e
    assert abs(read.value - READ_E) < STATISTICAL * read.sigma
    assert abs(gain.value - GAIN * factor) < STATISTICAL * gain.sigma
    assert read.sigma < 0.02 * READ_E


def test_the_roundings_of_summed_frames_add_up(tmp_path: Path) -> None:
    place = flats_and_darks(tmp_path, npy(lambda codes: codes.astype(np.uint32)), side=64, added=8, say=True)
    (channel,) = channels(place)
    read = channel.transfer.read_noise_e
    assert abs(read.value - READ_E * 8**0.5) < STATISTICAL * read.sigma
    assert read.sigma < 0.03 * read.value
    index = place / "index.csv"
    text = index.read_text()
    index.write_text("\n".join(line.rpartition(",")[0] for line in text.splitlines()))
    (unsaid,) = channels(place)
    read = unsaid.transfer.read_noise_e
    assert abs(read.value - READ_E * 8**0.5) < STATISTICAL * read.sigma
    assert read.sigma > 0.05 * read.value  # nobody says how many they are
    index.write_text(text.replace(",8", ",many"))
    with pytest.raises(InputError, match="summed must be how many frames were added up"):
        read_shots(place, cfa="mono")


def test_darks_of_one_time_tell_all_but_the_dark_current(tmp_path: Path) -> None:
    place = flats_and_darks(tmp_path, npy(lambda codes: codes.astype(np.uint16)), side=64, darks=(0.01,))
    (channel,) = channels(place)
    assert channel.transfer.dark_current_e_per_s.why_not == "all darks are of one exposure time, and two tell it"
    for name, true in (("gain_dn_per_e", GAIN), ("read_noise_e", READ_E), ("prnu", PRNU), ("dsnu_e", 2.0)):
        found = getattr(channel.transfer, name)
        assert abs(found.value - true) < STATISTICAL * found.sigma


@pytest.mark.parametrize("bend", [0.0, 0.15])
def test_figures_of_a_bent_read_out_say_so(bend: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    place = flats_and_darks(tmp_path, npy(lambda codes: codes.astype(np.uint16)), side=64, bend=bend)
    (channel,) = channels(place)
    tree = channel.as_dict()["figures"]
    bent = {name for name, stated in tree.items() if stated.get("remark") == "bent"}
    assert (channel.notes == ()) == (bend == 0.0)
    assert ({"gain_dn_per_e", "read_noise_e", "dsnu_e"} <= bent) == (bend > 0.0)
    assert not {"prnu", "linearity_error"} & bent
    assert app(["measure", "noise", str(place), "--cfa", "mono"], standalone_mode=False) in (None, 0)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("read noise")]
    assert ("bent" in lines[0]) == (bend > 0.0)


@pytest.mark.parametrize("cfa", ["mono", "RGGB"])
def test_flats_through_a_lens_tell_the_sensors_prnu(cfa: str, tmp_path: Path) -> None:
    y, x = np.mgrid[-1:1:160j, -1:1:160j]
    corners = 1.0 / (1.0 + 0.3 * (x**2 + y**2)) ** 2  # the fourth power of the cosine: 0.39 of the middle
    save = npy(lambda codes: codes.astype(np.uint16))
    for channel in channels(flats_and_darks(tmp_path, save, side=160, shape=corners), cfa):
        prnu = channel.transfer.prnu
        assert abs(prnu.value - PRNU) < STATISTICAL * prnu.sigma
        assert prnu.sigma < 0.05 * PRNU


@pytest.mark.parametrize("kind", ["int16", "int32", "int64", "below zero"])
def test_signed_whole_numbers_are_codes(kind: str, tmp_path: Path) -> None:
    signed = np.int16 if kind == "below zero" else np.dtype(kind)
    save = npy(lambda codes: (codes - (128 if kind == "below zero" else 0)).astype(signed))
    (channel,) = channels(flats_and_darks(tmp_path, save, side=64))
    gain, read = channel.transfer.gain_dn_per_e, channel.transfer.read_noise_e
    assert abs(gain.value - GAIN) < STATISTICAL * gain.sigma
    assert abs(read.value - READ_E) < STATISTICAL * read.sigma


def places(codes: np.ndarray) -> list[np.ndarray]:
    return [codes[row::2, col::2] for row, col in np.ndindex(2, 2)]


@pytest.mark.parametrize("last", [True, False])
def test_four_planes_of_a_filter_array_are_its_mosaic(last: bool, tmp_path: Path) -> None:
    codes = np.random.default_rng(2).integers(100, 4000, (12, 20)).astype(np.uint16)
    np.save(tmp_path / "a.npy", np.stack(places(codes), axis=2 if last else 0))
    with pytest.raises(InputError, match="holds four planes, as of a filter array; say which, in their order: --cfa"):
        read_picture(tmp_path / "a.npy")
    found = {plane.name: plane.samples for plane in read_picture(tmp_path / "a.npy", cfa="GRBG").planes}
    assert all(
        np.array_equal(found[name], part) for name, part in zip(("G1", "R", "B", "G2"), places(codes), strict=True)
    )


def test_mosaics_of_netpbm_and_matlab(tmp_path: Path) -> None:
    codes = np.random.default_rng(3).integers(100, 4000, (12, 20)).astype(np.uint16)
    head = b"P5\n# a camera's\n20 12\n4095\n"
    (tmp_path / "a.pgm").write_bytes(head + codes.astype(">u2").tobytes())
    words = "\n".join(map(str, codes.ravel()))
    (tmp_path / "b.pgm").write_text(f"P2 20 12 4095\n{words}\n")
    scipy.io.savemat(tmp_path / "c.mat", {"x": codes, "iso": 100.0})
    for name, white in (("a.pgm", 4095.0), ("b.pgm", 4095.0), ("c.mat", 65535.0)):
        planes = read_picture(tmp_path / name, cfa="RGGB").planes
        assert [plane.name for plane in planes] == ["R", "G1", "G2", "B"]
        assert np.array_equal(planes[0].samples, codes[::2, ::2])
        assert {plane.white for plane in planes} == {white}


@pytest.mark.parametrize(("data", "sentence"), rows("wrong-contents.txt", "PGM"))
def test_a_pgm_that_is_none(data: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "a.pgm").write_bytes(eval(data))
    with pytest.raises(InputError, match=sentence):
        read_picture(tmp_path / "a.pgm")


def test_noise_of_a_makers_own_files(tmp_path: Path) -> None:
    """Sony's: ISO and time are noted in the files; frames of another ISO are another sensor."""

    def save(codes: np.ndarray, path: Path, iso: int = 400) -> Path:
        noted: Tags = {33434: ("R", 1.0 if path.stem in LONG else 0.01), 34855: ("H", iso)}
        tags = mosaic_tags(codes, 16)
        data = codes.astype("<u2").tobytes()
        tiff_raw(path.with_suffix(".arw"), data, tags, make="SONY", model="ILCE-7M3", exif=noted)
        return path.with_suffix(".arw")

    place = flats_and_darks(tmp_path, save, side=96)
    for channel in measure_noise(read_shots(place)).channels:
        for name, true in (("gain_dn_per_e", GAIN), ("read_noise_e", READ_E), ("prnu", PRNU)):
            found = getattr(channel.transfer, name)
            assert abs(found.value - true) < STATISTICAL * found.sigma
    save(np.full((96, 96), 900), place / "001", iso=800)
    with pytest.raises(InputError, match=r"was taken at ISO 400 and '001\.arw' at ISO 800"):
        read_shots(place)


def test_black_levels_by_column_leave_codes(tmp_path: Path) -> None:
    """Of a DNG's frames, whose columns have blacks of their own, noise is measured."""
    columns = np.random.default_rng(4).integers(0, 9, 64)

    def save(codes: np.ndarray, path: Path) -> Path:
        shifted = (codes + columns).astype("<u2")
        tags: Tags = {
            **mosaic_tags(shifted, 16), 50713: ("H", (1, 1)), 50714: ("H", 128), 50717: ("I", 4095),
            50715: ("R", tuple(map(float, columns))),
        }  # fmt: skip
        first: Tags = {254: ("I", 1), 50706: ("B", bytes((1, 4, 0, 0)))}
        noted: Tags = {34855: ("H", 400)}
        target = path.with_suffix(".dng")
        tiff_raw(target, shifted.tobytes(), tags, make="Acme", model="One", first=first, exif=noted)
        return target

    place = flats_and_darks(tmp_path, save, side=64)
    for channel in measure_noise(read_shots(place)).channels:
        dsnu, read = channel.transfer.dsnu_e, channel.transfer.read_noise_e
        assert abs(dsnu.value - 2.0) < STATISTICAL * dsnu.sigma
        assert abs(read.value - READ_E) < STATISTICAL * read.sigma
