"""The count of random numbers in a report is what generators really draw."""

import pytest
from electronics import EVERY, Spy

import camsim
from camsim.sensor.electronics import ORDER

# Chance decides how many defects and telegraph photosites there are; they are left out of the count.
COUNTED = {name: stage for name, stage in EVERY.items() if name not in ("defects", "telegraph_noise")}
UNEVEN = {"dark_current": camsim.DarkCurrent(e_per_s=2.0, nonuniformity=0.1)}


@pytest.mark.parametrize(
    "names", [["shot_noise"], ["prnu"], ["prnu", "crosstalk"], ["read_noise"], ["dark_current"], list(COUNTED)]
)
@pytest.mark.parametrize("region", [None, camsim.Region(rows=70, cols=9, origin=(100, 20))])
def test_the_count(monkeypatch, names, region):
    spy = Spy(monkeypatch)
    camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=8.0))
    stages = COUNTED | UNEVEN
    camera = camera.replace(rows=200, cols=40, **(dict.fromkeys(ORDER) | {name: stages[name] for name in names}))
    frame = camera.expose(
        camsim.Scene(background=0.5),
        light=camsim.Light("D55", illuminance_lux=1000.0),
        exposure=camsim.Exposure(time_s=0.01, iso=camera.adc.base_iso),
        region=region,
    )
    assert frame.report.work["random_numbers"] == spy.numbers
    assert len(frame.report.electronics) == len(names)
