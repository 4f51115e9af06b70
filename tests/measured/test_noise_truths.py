"""Sensors of a few lines of numpy whose numbers are known: what flats and darks of them tell, and what they cannot."""

import json
import math
import re
from dataclasses import dataclass

import numpy as np
import pytest

from camsim.measure.noise import Group, Shots, measure_noise, read_shots
from tests.tables import rows

TIME_S = 0.01
NONE_FULL = r"the brightest flats, at exposure 9000, do not fill the channel"


@dataclass(frozen=True)
class Sensor:
    """Charge of photons, a well, offsets, a gain of codes, and a last code; ``drift`` is the lamp's, of its light.

    Light falls off by ``uneven`` of its middle to each side, as behind a lens.
    """

    gain: float = 0.5
    read_e: float = 5.0
    row_e: float = 0.0
    frame_e: float = 0.0
    prnu: float = 0.0
    well_e: float = 1e9
    last_dn: int = 65535
    dark_e_per_s: float = 20.0
    drift: float = 0.0
    uneven: float = 0.0
    side: int = 64
    bayer: bool = False

    def shots(self, rng, levels, *, clipped=None, times=(0.001, 3.0, 10.0), frames=3):
        shape = (self.side, self.side)
        index = np.add.outer(np.arange(self.side) % 2, np.arange(self.side) % 2).astype(np.uint8) * self.bayer
        response = np.array([0.4, 1.0, 0.5])[index] if self.bayer else 1.0
        off = np.linspace(-1.0, 1.0, self.side) ** 2
        light = response * (1.0 - self.uneven * (off[:, None] + off)) * (1.0 + self.prnu * rng.normal(size=shape))

        def shot(exposure, time_s):
            mean_e = exposure * (1.0 + self.drift * rng.normal()) * light + self.dark_e_per_s * time_s
            charge = np.minimum(rng.poisson(mean_e, shape), self.well_e) + self.read_e * rng.normal(size=shape)
            charge += self.row_e * rng.normal(size=(self.side, 1)) + self.frame_e * rng.normal()
            return np.clip(np.rint(400 + self.gain * charge), 0, self.last_dn).astype(np.uint16)

        def group(kind, exposure, time_s, count):
            codes = [shot(exposure, time_s) for _ in range(count)]
            return Group(kind=kind, exposure=float(exposure), time_s=time_s, codes=codes)

        flats = [group("flat", level, TIME_S, frames) for level in levels]
        darks = [group("dark", 0.0, t, frames) for t in (TIME_S, *times)]
        full = [] if clipped is None else [group("clipped", clipped, TIME_S, 2)]
        names = ("R", "G", "B") if self.bayer else ("Y",)
        return Shots(name="own", channels=names, channel_index=index, groups=(*flats, *darks, *full))

    def pulls(self, truth, *, trials, **taken):
        """Return how far figures of fresh sensors are off, root of mean square, in their own standard errors."""
        off = []
        for seed in range(trials):
            stated = measure_noise(self.shots(np.random.default_rng(seed), **taken)).channels[0].figures()
            off.append([(stated[name].value - true) / stated[name].sigma for name, true in truth.items()])
        return dict(zip(truth, np.sqrt(np.mean(np.square(off), axis=0)), strict=True))


CONVERTER = r"^the converter ends at [78]\d\d\d e⁻, before the well is full"
MONO, TWO_FULL = (500, 1000, 2000, 4000, 6000), (500, 1000, 2000, 3000, 4000, 9000)


@pytest.mark.parametrize(("sensor", "levels", "clipped", "stated"), rows("wells.txt", "full or not"))
def test_a_channel_is_full_or_has_no_full_well(rng, sensor, levels, clipped, stated):
    """The brightest flat of all was a full well of 2800 e⁻ where 12 000 fit in, and of R where G alone was full.

    Where half of the photosites are full the mean is no saturation.
    """
    for channel in measure_noise(eval(sensor).shots(rng, eval(levels), clipped=eval(clipped))).channels:
        figures, expected = channel.figures(), eval(stated)[channel.channel]
        well, saturation = figures["full_well_e"], figures["saturation_e"]
        if isinstance(expected, int):
            assert abs(well.value - expected) < 4.5 * well.sigma
            assert saturation == well
            continue
        assert re.search(expected, well.why_not)
        if expected == CONVERTER:
            assert abs(saturation.value - 8000.0) < 4.5 * saturation.sigma
            continue
        assert re.search(NONE_FULL, saturation.why_not)
        for name in ("snr_max_db", "dynamic_range_db"):
            assert figures[name].why_not == saturation.why_not
        assert figures["sensitivity_threshold_e"].measurable
        json.dumps(channel.as_dict(), allow_nan=False)


def test_codes_that_a_program_moved_after_the_converter_are_its_end(rng):
    """Each column has another last code: none is heaped on, but no noise of reading is left."""
    shots = Sensor(last_dn=4400).shots(rng, MONO, clipped=20_000)
    moved = rng.integers(0, 3, (1, 64)).astype(np.uint16)
    codes = [each - moved for each in shots.groups[-1].codes]
    full = Group(kind="clipped", exposure=20_000.0, time_s=TIME_S, codes=codes)
    shots = Shots(name="own", channels=("Y",), channel_index=shots.channel_index, groups=(*shots.groups[:-1], full))
    (channel,) = measure_noise(shots).channels
    assert channel.transfer.full_well_e.why_not.startswith("the converter ends at")
    assert channel.saturation_e.value == pytest.approx(8000.0, rel=0.02)


@pytest.mark.parametrize(
    ("sensor", "clipped"),
    [
        (Sensor(well_e=8000, dark_e_per_s=390.0), 30_000),
        (Sensor(last_dn=4400, dark_e_per_s=390.0), None),
    ],
)
def test_darks_that_are_full_tell_no_dark_current(sensor, clipped):
    """Of 20 s, nearly all of its photosites full, and 30 s: the slope was off by 140 of its errors."""
    pulls = sensor.pulls(
        {"dark_current_e_per_s": 390.0}, trials=12, levels=MONO[:-1], clipped=clipped, times=(0.1, 1, 3, 10, 20, 30)
    )
    assert pulls["dark_current_e_per_s"] < 1.8


def test_two_darks_that_are_not_full_are_needed(rng):
    shots = Sensor(well_e=8000, dark_e_per_s=9000.0).shots(rng, MONO, clipped=30_000, times=(1.0, 3.0))
    (channel,) = measure_noise(shots).channels
    assert channel.transfer.dark_current_e_per_s.why_not.startswith("1 of 3 darks is not full, and two tell it")
    assert channel.transfer.full_well_e.measurable


@pytest.mark.parametrize(
    "sensor",
    [
        Sensor(well_e=8000, drift=0.01, prnu=0.01),
        Sensor(well_e=8000, drift=0.002, frame_e=3.0),
        Sensor(well_e=40_000, gain=0.2, drift=0.02, uneven=0.1),
        Sensor(well_e=3000, gain=0.8, read_e=4.0, row_e=20.0),
        Sensor(well_e=1000, gain=2.0, read_e=40.0),
    ],
)
def test_figures_know_their_errors(sensor):
    """A lamp that drifts by 1 % made the gain 17 % too large (110 errors), all levels share what their dark is off.

    What rows have in common is noise of the dark, what the frame has is not; nor what the lamp scales of uneven light.
    """
    well_e = sensor.well_e
    truth = {
        "gain_dn_per_e": sensor.gain,
        "read_noise_e": math.sqrt(sensor.read_e**2 + sensor.row_e**2 + sensor.dark_e_per_s * 0.001),
        "full_well_e": well_e - sensor.dark_e_per_s * TIME_S,
        "dark_current_e_per_s": sensor.dark_e_per_s,
    }
    levels = [share * well_e for share in (0.04, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7)]
    for name, rms in sensor.pulls(truth, trials=16, levels=levels, clipped=4 * well_e).items():
        assert 0.55 < rms < 1.35, name


def test_patterns_that_chance_hides_have_a_limit():
    """Of a sensor without any, PRNU was 0.0037 ± 0.0006; of one with little the limit lies above it."""
    for prnu in (0.0, 0.0003):
        for seed in range(6):
            shots = Sensor(well_e=8000, prnu=prnu, side=40).shots(np.random.default_rng(seed), MONO, clipped=30_000)
            (channel,) = measure_noise(shots).channels
            stated = channel.as_dict()["figures"]
            for name, true in (("prnu", prnu), ("dsnu_e", 0.0)):
                assert stated[name]["value"] is None
                assert "noise gives as much by chance" in stated[name]["not_measurable"]
                assert stated[name]["at_most"] > true
            assert stated["prnu"]["at_most"] < 0.02


@pytest.mark.parametrize("kind", ["u8", ">u4"])
def test_a_folder_of_wide_codes_keeps_them(rng, tmp_path, kind):
    """Sums of frames wrapped at 65 536: a saturation of 13 600 e⁻ for 30 000."""
    shots = Sensor(well_e=8000).shots(rng, MONO, clipped=30_000)
    lines = ["file,kind,exposure,time_s"]
    for group in shots.groups:
        for codes in group.codes:
            lines.append(f"{len(lines)}.npy,{group.kind},{group.exposure},{group.time_s}")
            np.save(tmp_path / f"{len(lines) - 1}.npy", (70_000 + 16 * codes.astype(np.int64)).astype(kind))
    (tmp_path / "index.csv").write_text("\n".join(lines))
    (wide,) = measure_noise(read_shots(tmp_path)).channels
    (narrow,) = measure_noise(shots).channels
    assert wide.transfer.gain_dn_per_e.value == pytest.approx(16 * narrow.transfer.gain_dn_per_e.value)
    assert wide.saturation_e.value == pytest.approx(narrow.saturation_e.value)
