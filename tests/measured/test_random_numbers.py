"""The count of random numbers in a report is what generators really draw."""

import numpy as np
import pytest
from camsim.sensor.noise import ColumnNoise, DarkCurrent, Dsnu, FlickerRows, OutputNoise, Prnu, ResetNoise, RowNoise

import camsim
from camsim.sensor import chain, streams


class Counting:
    """A generator that counts what it draws."""

    drawn = 0

    def __init__(self, rng):
        self._rng = rng

    def standard_normal(self, size, **how):
        numbers = self._rng.standard_normal(size, **how)
        Counting.drawn += np.size(numbers)
        return numbers

    def poisson(self, mean):
        Counting.drawn += np.size(mean)
        return self._rng.poisson(mean)


STAGES = {
    "prnu": Prnu(fraction=0.01),
    "crosstalk": camsim.Crosstalk(((0.0, 0.01, 0.0), (0.01, 0.96, 0.01), (0.0, 0.01, 0.0))),
    "dark_current": DarkCurrent(e_per_s=2.0, nonuniformity=0.1),
    "reset_noise": ResetNoise(sigma_e=2.0),
    "read_noise": camsim.ReadNoise(sigma_e=3.0),
    "row_noise": RowNoise(sigma_e=1.0),
    "flicker_rows": FlickerRows(sigma_e=1.0),
    "column_noise": ColumnNoise(sigma_e=1.0),
    "dsnu": Dsnu(sigma_e=0.5),
    "output_noise": OutputNoise(sigma_dn=0.5),
}


@pytest.mark.parametrize(
    "names", [[], ["prnu"], ["prnu", "crosstalk"], ["read_noise"], ["dark_current"], list(STAGES)], ids=",".join
)
@pytest.mark.parametrize("region", [None, camsim.Region(rows=70, cols=9, origin=(100, 20))])
def test_the_count(monkeypatch, names, region):
    true_generator = streams.generator
    counting = lambda *args, **how: Counting(true_generator(*args, **how))  # noqa: E731
    monkeypatch.setattr(streams, "generator", counting)
    monkeypatch.setattr(chain, "generator", counting)
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    nothing = dict.fromkeys((*STAGES, "defects", "blooming"))
    camera = camera.replace(rows=200, cols=40, **{**nothing, **{name: STAGES[name] for name in names}})
    Counting.drawn = 0
    frame = camera.expose(
        camsim.Scene(background=0.5),
        light=camsim.Light("D55", illuminance_lux=1000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=camera.adc.base_iso),
        region=region,
    )
    assert frame.report.work["random_numbers"] == Counting.drawn
