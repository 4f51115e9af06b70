"""The package emva1288 on the same frames: gain, dark noise and non-uniformities agree.

Of two frames a level its gain has a fifteenth of our degrees of freedom. Not compared: all about photons (one photon is
one electron here), its saturation (where the variance is largest) and its linearity (weights of Release 3).
"""

import numpy as np
import pytest

import camsim
from camsim.api import load_camera
from camsim.measure.noise import measure_noise, take_shots
from camsim.measure.noise.taking import TIME_S

pytestmark = pytest.mark.clients


def by_emva1288(shots) -> dict[str, float]:
    """Return its figures of a monochrome sensor, fed through its own reduction."""
    if not hasattr(np, "asfarray"):  # version 1.0.2 of the package was written for numpy 1
        vars(np)["asfarray"] = lambda values: np.asarray(values, dtype=float)
    from emva1288.process import routines
    from emva1288.process.data import Data1288
    from emva1288.process.results import Results1288

    def images(codes, kind):
        whole = routines.get_int_imgs([each.astype(np.int64) for each in codes])
        if kind == "spatial":
            return whole
        return {"sum": np.sum(whole["sum"]), "pvar": np.sum(whole["pvar"]), "dmean": whole["dmean"]}

    photons = 10_000.0
    (dark,) = (group.codes for group in shots.of("dark") if group.time_s == TIME_S)
    temporal = {group.exposure * photons: images(group.codes[:2], "temporal") for group in shots.of("flat")}
    temporal[0.0] = images(dark[:2], "temporal")
    half = min(shots.of("flat"), key=lambda group: abs(group.exposure - 0.5))
    spatial = {half.exposure * photons: images(half.codes, "spatial"), 0.0: images(dark, "spatial")}
    rows, cols = dark[0].shape
    exposure_ns = TIME_S * 1e9
    data = {"temporal": {exposure_ns: temporal}, "spatial": {exposure_ns: spatial}, "height": rows, "width": cols}
    results = Results1288(Data1288(data).data)
    names = {"gain_dn_per_e": "K", "read_noise_e": "sigma_d", "dsnu_e": "DSNU1288", "prnu": "PRNU1288"}
    found = {ours: float(getattr(results, theirs)) for ours, theirs in names.items()}
    return found | {"prnu": found["prnu"] / 100.0}


def test_another_program_says_the_same():
    camera = load_camera("mono-345", lens=camsim.Airy(f_number=8.0))
    shots = take_shots(camera, side=300, frames=16)
    ours = measure_noise(shots).channels[0].figures()
    for name, theirs in by_emva1288(shots).items():
        tolerance = {"gain_dn_per_e": 0.01, "read_noise_e": 0.02}.get(name, 0.03)
        assert theirs == pytest.approx(ours[name].value, rel=tolerance), name
