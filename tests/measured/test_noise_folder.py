"""Flats and darks by way of a folder: the same figures as from the sensor, and what a folder must hold."""

import dataclasses
import re  # noqa: F401 (changes are told by their text)

import numpy as np
import pytest
from tolerances import STATISTICAL

import camsim
from camsim.api import load_camera
from camsim.errors import CamsimError, InputError, InvalidValueError, UnsupportedError
from camsim.measure.filters import filter_rows
from camsim.measure.noise import Group, Shots, expected_of, measure_noise, read_shots, take_shots, write_shots
from camsim.measure.noise.measuring import _healthy
from camsim.measure.noise.shots import codes_of
from camsim.measure.noise.taking import frames_of
from camsim.measure.noise.xml_file import xml_of
from camsim.measure.reading import read_picture
from tests.tables import rows

SIDE, FRAMES = 40, 4


@pytest.fixture(scope="module")
def camera():
    return load_camera("d40-like", lens=camsim.Airy(f_number=8.0))


@pytest.fixture(scope="module")
def folder(camera, tmp_path_factory):
    place = tmp_path_factory.mktemp("noise") / "shots"
    write_shots(place, dict(frames_of(camera, side=SIDE, frames=FRAMES)))
    return place


def test_a_folder_gives_the_sensors_own_figures(camera, folder):
    shots = take_shots(camera, side=SIDE, frames=FRAMES)
    taken = measure_noise(shots, expected={name: expected_of(camera, name) for name in shots.channels})
    read = measure_noise(read_shots(folder))
    for one, other in zip(taken.channels, read.channels, strict=True):
        assert one.channel == other.channel
        assert one.figures() == other.figures()
        assert other.expected is None
        for name in ("gain_dn_per_e", "read_noise_e", "dark_current_e_per_s", "prnu"):
            estimate = one.figures()[name]
            assert abs(estimate.value - one.expected[name]) < STATISTICAL * estimate.sigma, name
        assert not one.transfer.full_well_e.measurable  # the converter ends first
        assert one.saturation_e.value == pytest.approx((4095 - 100) * 10.0, rel=0.05)
    tree = taken.as_dict()
    assert tree["channels"][0]["figures"]["gain_dn_per_e"]["unit"] == "DN/e⁻"
    assert tree["channels"][0]["figures"]["full_well_e"]["value"] is None


def test_a_transfer_is_taken_warm_at_another_gain_and_again(camera):
    """14 °C are two doublings, and twice the ISO is twice the gain; another seed is other noise of the same sensor."""
    warm = {"iso": 2.0 * camera.adc.base_iso, "temperature_c": camera.dark_current.at_c + 14.0}
    one, again, other = (take_shots(camera, side=32, frames=2, seed=seed, **warm) for seed in (1, 1, 2))
    first, same, fresh = (shots.of("dark")[-1].codes[0] for shots in (one, again, other))
    assert np.array_equal(first, same)
    assert not np.array_equal(first, fresh)
    for shots in (one, other):
        transfer = measure_noise(shots).channels[0].transfer
        stated = expected_of(camera, "R", **warm)
        for name, true in (
            ("gain_dn_per_e", 2.0 / camera.adc.electrons_per_dn),
            ("dark_current_e_per_s", 4.0 * camera.dark_current.e_per_s),
        ):
            estimate = getattr(transfer, name)
            assert abs(estimate.value - true) < STATISTICAL * estimate.sigma, name
            assert stated[name] == pytest.approx(true)


def test_rounding_alone_makes_no_defects():
    """Of little noise: a photosite that flips in half of the frames is sound; five codes off is a defect."""
    codes = [np.full((8, 8), 10, np.uint16) for _ in range(4)]
    codes[0][2, 3] = codes[1][2, 3] = 11
    for frame in codes:
        frame[5, 5] = 15
    good = _healthy(Group(kind="dark", exposure=0.0, time_s=1.0, codes=codes), np.zeros((8, 8), np.uint8), 1.0)
    assert np.argwhere(~good).tolist() == [[5, 5]]


def test_the_reference_implementation_reads_the_xml(folder, tmp_path):
    routines = pytest.importorskip("emva1288.process.routines")
    channel = measure_noise(read_shots(folder)).channels[0]
    file = tmp_path / "r.xml"
    file.write_bytes(xml_of(channel))
    sections = routines.xml_to_dict(str(file)).values()
    read = {name: figure["value"] for section in sections for name, figure in section.items()}
    figures = channel.figures()
    for theirs, ours, factor in (
        ("k", "gain_dn_per_e", 1.0),
        ("sigma_d", "read_noise_e", 1.0),
        ("u_e_sat", "saturation_e", 1.0),
        ("snr_max_db", "snr_max_db", 1.0),
        ("u_i_mean", "dark_current_e_per_s", 1.0),
        ("dsnu1288", "dsnu_e", 1.0),
        ("prnu1288", "prnu", 100.0),
    ):
        stated = figures[ours]
        assert read[theirs] == (pytest.approx(factor * stated.value, rel=1e-8) if stated.measurable else None), theirs
    # The signal whose noise (read noise, a twelfth of a squared code, its own photons) is as large as itself.
    least_e = read["u_e_min"]
    assert least_e**2 == pytest.approx(read["sigma_d"] ** 2 + read["inverse_k"] ** 2 / 12.0 + least_e, rel=1e-6)
    assert read["dr"] == pytest.approx(read["u_e_sat"] / least_e, rel=1e-8)
    assert 20.0 * np.log10(read["dr"]) == pytest.approx(read["dr_db"], rel=1e-6)
    assert read["inverse_k"] * read["k"] == pytest.approx(1.0)


def test_white_noise_is_flat_in_the_spectrogram_and_a_stripe_is_a_line():
    rng = np.random.default_rng(2)
    stripes = 3.0 * np.cos(2 * np.pi * np.arange(64) / 8)

    def group(kind, exposure, time_s, level, count=8):
        codes = [rng.normal(level, 2.0 + 0.02 * level, (64, 64)) + stripes for _ in range(count)]
        return Group(kind=kind, exposure=exposure, time_s=time_s, codes=[np.rint(c).astype(np.uint16) for c in codes])

    flats = [group("flat", e, 0.01, 100.0 + 800.0 * e) for e in (0.1, 0.3, 0.5, 0.7, 0.9)]
    shots = Shots(
        name="made",
        channels=("Y",),
        channel_index=np.zeros((64, 64), np.uint8),
        groups=(*flats, group("dark", 0.0, 0.01, 100.0), group("dark", 0.0, 10.0, 120.0)),
    )
    (channel,) = measure_noise(shots).channels
    dark = channel.dark
    peak = int(np.argmax(dark.rows))
    assert dark.frequency_cycles_per_pixel[peak] == pytest.approx(1 / 8)
    assert dark.rows[peak] == pytest.approx(3.0 / 2 * np.sqrt(64), rel=0.05)
    others = np.delete(dark.rows, [0, peak])
    assert others.mean() == pytest.approx(4.0 / np.sqrt(8), rel=0.1)
    # Parseval: all frequencies together are the variance, those inside counted on both sides of 0.
    mean = np.mean(shots.groups[5].codes, axis=0)
    for power in (dark.rows**2, dark.cols**2):
        assert np.average(power, weights=[1, *[2] * 31, 1]) == pytest.approx(mean.var(), rel=1e-9)


def test_the_range_is_as_sure_as_saturation_and_read_noise_are(folder):
    """EMVA 1288 R4.0's formula with rounding, at codes and a gain moved by their errors; the gain moves all."""

    def threshold_e(read_noise_dn, gain_dn_per_e):
        return np.sqrt((read_noise_dn**2 + 1.0 / 12.0) / gain_dn_per_e**2 + 0.25) + 0.5

    def range_db(saturation_dn, read_noise_dn, gain_dn_per_e):
        return 20.0 * np.log10(saturation_dn / gain_dn_per_e / threshold_e(read_noise_dn, gain_dn_per_e))

    channel = measure_noise(read_shots(folder)).channels[0]
    gain = channel.transfer.gain_dn_per_e
    share = gain.sigma / gain.value
    codes = [channel.saturation_e, channel.transfer.read_noise_e]
    values = np.array([*(figure.value * gain.value for figure in codes), gain.value])
    shares = np.array([*(np.sqrt((figure.sigma / figure.value) ** 2 - share**2) for figure in codes), share])
    step = 1e-4
    for found, formula, of in (
        (channel.dynamic_range_db, range_db, slice(0, 3)),
        (channel.sensitivity_threshold_e, threshold_e, slice(1, 3)),
    ):
        at, steps = values[of], step * np.diag(values[of] * shares[of])
        assert found.value == pytest.approx(formula(*at))
        moved = [formula(*(at + each)) - found.value for each in steps]
        assert found.sigma == pytest.approx(np.linalg.norm(moved) / step, rel=1e-3)


@pytest.mark.parametrize(("change", "sentence"), rows("wrong-contents.txt", "a folder of shots"))
def test_what_a_folder_must_hold(folder, tmp_path, change, sentence):
    for file in folder.iterdir():
        (tmp_path / file.name).symlink_to(file) if file.suffix != ".csv" else None
    (tmp_path / "index.csv").write_text(eval(change)((folder / "index.csv").read_text()))
    with pytest.raises(CamsimError, match=sentence):
        measure_noise(read_shots(tmp_path))


def test_an_empty_folder(tmp_path):
    with pytest.raises(CamsimError, match=r"index\.csv' is missing; it says what each frame is"):
        read_shots(tmp_path)


@pytest.mark.parametrize("foreign", [False, True])
def test_frames_of_two_gains(tmp_path, foreign):
    """Darks of twice the ISO: read noise of 19 e⁻ for 9, dark current twice as large. EXIF tells it of any camera's."""
    lines = ["file,kind,exposure,time_s"]
    for name, setting in (("a.dng", 200.0), ("b.dng", 1e5)):
        changes = [f"exposure.iso={setting}", "region={rows: 40, cols: 40}", "render.tolerance=1e-2"]
        camsim.capture("flat-field", overrides=changes).save(tmp_path / name)
        if foreign:
            held = (tmp_path / name).read_bytes()
            (tmp_path / name).write_bytes(held.replace(b"urn:camsim:", b"urn:camera:"))
        assert (read_picture(tmp_path / name).description is None) == foreign
        lines.append(f"{name},flat,1,0.01")
    (tmp_path / "index.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"a\.dng' was taken at ISO 200 and 'b\.dng' at ISO 100000: .*two gains"):
        read_shots(tmp_path)


GAINS = {"R": 0.6, "G": 1.0, "B": 0.75, "W": 1.4, "Y": 1.0}


def written(place, pattern, *, gain=0.5):
    """Flats and darks as bare arrays, of a sensor without PRNU behind filters and a lens that darkens its corners."""
    rng, lines = np.random.default_rng(8), ["file,kind,exposure,time_s"]
    filters = np.array([[GAINS[letter] for letter in row] for row in pattern])
    tiles = [-(-48 // size) for size in filters.shape]
    seen = np.tile(filters, tiles)[:48, :48] * (1.0 - 0.2 * np.hypot(*(np.indices((48, 48)) - 23.5)) / 34.0)
    shots = [("flat", e, 0.01) for e in (1, 2, 3, 4, 5)] + [("dark", 0, 0.01), ("dark", 0, 1.0)]
    for number, (kind, exposure, time_s) in enumerate(shots * 2):
        codes = gain * rng.poisson(3000.0 * exposure * seen) + rng.normal(100.0, 2.0, seen.shape)
        np.save(place / f"{number}.npy", np.rint(codes).astype(np.uint16))
        lines.append(f"{number}.npy,{kind},{exposure},{time_s}")
    (place / "index.csv").write_text("\n".join(lines))
    return place


@pytest.mark.parametrize("cfa", ["RGGB", "x-trans", "mono"])
def test_filters_that_no_file_names(tmp_path, cfa):
    """Taken for one channel, what they differ by was PRNU: 0.16 for 0.006, and sure of it."""
    rows = filter_rows(cfa)
    place = written(tmp_path, rows)
    if cfa != "mono":
        with pytest.raises(InputError, match="as behind colour filters, and the files name none; give the array"):
            read_shots(place)
    shots = read_shots(place) if cfa == "mono" else read_shots(place, cfa=cfa)
    assert {name[0] for name in shots.channels} == set("".join(rows))
    for channel in measure_noise(shots).channels:
        gain = channel.transfer.gain_dn_per_e
        assert abs(gain.value - 0.5) < STATISTICAL * gain.sigma
        prnu = channel.transfer.prnu
        assert (prnu.value if prnu.measurable else prnu.at_most) < 0.012  # the corners are the lens's
    assert read_shots(place, cfa="mono").channels == ("Y",)


def made(levels, *, dark=0.0, long_dark=5.0, exposures=(1, 2, 3, 4, 5), noise=True, clipped=None):
    """Shots of a sensor of 0.5 DN per electron: electrons of flats and darks, Poisson or of read noise alone."""
    rng = np.random.default_rng(5)

    def group(kind, exposure, time_s, mean_e):
        charge = rng.poisson(mean_e, (2, 40, 40)) if noise else np.full((2, 40, 40), float(mean_e))
        codes = np.rint(0.5 * charge + rng.normal(100.0, 2.0, charge.shape))
        return Group(kind=kind, exposure=exposure, time_s=time_s, codes=[c.astype(np.uint16) for c in codes])

    flats = [group("flat", e, 0.01, level) for e, level in zip(exposures, levels, strict=True)]
    full = [] if clipped is None else [group("clipped", 50.0, 0.01, clipped)]
    darks = [group("dark", 0.0, 0.01, dark), group("dark", 0.0, 1.0, long_dark)]
    index = np.zeros((40, 40), np.uint8)
    return Shots(name="mine", channels=("Y",), channel_index=index, groups=(*flats, *full, *darks))


@pytest.mark.parametrize(("shots", "sentence"), rows("wrong-contents.txt", "flats"))
def test_flats_show_light_and_more_of_it(shots, sentence):
    """With the cap on the gain was −6 DN/e⁻, and darks for flats ended in a traceback."""
    with pytest.raises(UnsupportedError, match=f"^mine: .*{eval(sentence)}"):
        measure_noise(made(**eval(shots)))


def test_faint_flats_and_full_ones_are_let_through():
    """One that lies below its dark by chance, and flats of one saturation."""
    shots = made([0.0, 1000, 2000, 3000, 4000, 6000, 5990], exposures=(0.001, 1, 2, 3, 4, 6, 7), dark=0.1)
    gain = measure_noise(shots).channels[0].transfer.gain_dn_per_e
    assert abs(gain.value - 0.5) < STATISTICAL * gain.sigma


@pytest.mark.parametrize("kind", ["flat", "dark"])
def test_copies_of_a_frame_are_refused(kind):
    """Each frame twice: of three and their copies the gain was four fifths, by fifty of its errors."""
    shots = made([1000, 2000, 3000, 4000, 5000])
    twice = [dataclasses.replace(g, codes=[*g.codes, g.codes[0].copy()]) if g.kind == kind else g for g in shots.groups]
    with pytest.raises(UnsupportedError, match=f"^mine: has 3 frames of kind {kind} at .*of which 2 differ: copies"):
        measure_noise(dataclasses.replace(shots, groups=tuple(twice)))


def test_frames_that_rounding_or_the_converter_makes_alike_are_no_copies():
    shots = made([1000, 2000, 3000, 4000, 5000, 200_000], exposures=(1, 2, 3, 4, 5, 200))
    ended = [np.full_like(codes, 4095) for codes in shots.groups[5].codes]
    quiet = [dataclasses.replace(g, codes=[np.full((40, 40), 100)] * 2) for g in shots.groups if g.kind == "dark"]
    full = dataclasses.replace(shots.groups[5], codes=ended)
    measure_noise(dataclasses.replace(shots, groups=(*shots.groups[:5], full, *shots.groups[6:])))
    (channel,) = measure_noise(dataclasses.replace(shots, groups=(*shots.groups[:6], *quiet))).channels
    assert channel.transfer.gain_dn_per_e.why_not.startswith("the dark noise of 0 DN is under 0.5 DN")


@pytest.mark.parametrize(
    ("shots", "reason"),
    [
        ({"levels": [1000, 2000, 3000, 4000, 5000], "noise": False}, "variance does not grow with the signal"),
        ({"levels": [5000, 5000, 5001, 5001, 5002]}, "no flat lies within 70 % of saturation"),
    ],
)
def test_what_tells_no_gain_is_not_measurable(shots, reason):
    """Frames that a program has averaged; a well that every flat fills, which ended in a traceback."""
    (channel,) = measure_noise(made(**shots)).channels
    stated = channel.figures()
    for name in ("gain_dn_per_e", "read_noise_e", "dark_current_e_per_s", "saturation_e", "dynamic_range_db"):
        assert stated[name].why_not.startswith(reason), name
    assert channel.as_dict()["figures"]["gain_dn_per_e"]["value"] is None
    xml_of(channel)


def blind(camera, *channels):
    dark = camsim.Curve((400.0, 700.0), (0.0, 0.0))
    curves = [(c, dark if c in channels else curve) for c, curve in camera.quantum_efficiency.curves]
    return camera.replace(quantum_efficiency=dataclasses.replace(camera.quantum_efficiency, curves=curves))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda camera: blind(camera, "B"), r"^D40-like, 4\.88 µm: B sees nothing of even light \(E\)"),
        (lambda camera: camera.replace(filters=(0.0,)), r"^D40-like, 4\.88 µm: R, G and B see nothing of even light"),
        (lambda camera: camera.replace(defects=camsim.Defects(dead_fraction=1.0)), r"shows no light in R"),
    ],
)
def test_channels_that_see_nothing(camera, change, sentence):
    """It was an irradiance of infinite watts, which nobody had asked for, and a traceback."""
    with pytest.raises(UnsupportedError, match=sentence):
        measure_noise(take_shots(change(camera), side=32, frames=2))


def test_codes_in_any_kind_of_array_are_codes(tmp_path):
    """Eight bits, MATLAB's doubles, one plane before or behind; a JPEG's and fractions are refused."""
    codes = np.random.default_rng(2).integers(3, 250, (6, 80))
    kinds = {"a": codes.astype(np.uint8), "b": codes.astype(float), "c": codes[None], "d": codes[:, :, None]}
    for name, array in kinds.items():
        np.save(tmp_path / f"{name}.npy", array)
    (tmp_path / "e.pgm").write_bytes(b"P5 80 6 255\n" + codes.astype(np.uint8).tobytes())
    for name in ("a.npy", "b.npy", "c.npy", "d.npy", "e.pgm"):
        channels, index, found = codes_of(read_picture(tmp_path / name, cfa="RGGB", stored=True))
        assert channels == ("R", "G1", "G2", "B")
        assert np.array_equal(found, codes)
        assert index[:2, :2].tolist() == [[0, 1], [2, 3]]
    np.save(tmp_path / "f.npy", codes / 255.0)
    with pytest.raises(UnsupportedError, match="no codes but fractions"):
        codes_of(read_picture(tmp_path / "f.npy", cfa="RGGB", stored=True))
    with pytest.raises(InvalidValueError, match="it has 8 bits"):
        read_picture(tmp_path / "a.npy", cfa="RGGB")
