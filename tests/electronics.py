"""Every electronic stage with what it promises; all laws and chains of the tests take their stages from here."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import camsim
from camsim.api import load_camera
from camsim.errors import CamsimError
from camsim.sensor import streams
from camsim.sensor.chain import record
from camsim.sensor.electronics import ORDER, Electronics
from camsim.sensor.stage import Context

TIME_S = 0.25
ELECTRONS_PER_DN = 4.0
WELL = camsim.FullWell(900.0)
KERNEL = ((0.01, 0.02, 0.0), (0.03, 0.9, 0.015), (0.0, 0.02, 0.005))


def refused_in_a_sentence(file, sentence):
    """Load a sensor file that is wrong, and find the sentence in what is said, and no more than one."""
    with pytest.raises(CamsimError) as caught:
        load_camera(file, lens=camsim.Airy(f_number=8.0))
    assert sentence in str(caught.value)
    assert "\n" not in str(caught.value)


@dataclass(frozen=True, kw_only=True)
class Law:
    """A stage, at TIME_S and ELECTRONS_PER_DN.

    idle     : the same doing nothing; None where there is no such thing
    mean     : after it, of the mean before it (a flat field)
    variance : that it adds to a mean
    each     : what draws a number of its own: "photosite", "row" or "column"
    needs    : stages that it cannot act without
    adds     : whether it adds numbers that do not depend on the charge
    patterned : whether a temporal stage has a fixed pattern of the sensor as well
    """

    stage: object
    idle: object = None
    mean: object = lambda m: m
    variance: object = lambda m: 0.0
    each: str = "photosite"
    needs: tuple = ()
    adds: bool = False
    patterned: bool = False

    @property
    def chain(self):
        return Electronics(**({"shot_noise": None} | fields_of(*self.needs, self.stage))).stages


def fields_of(*stages):
    """The fields of a camera that has these stages."""
    listed = {stage.name: stage for stage in stages if stage.name in ORDER}
    return listed | {"extra_stages": tuple(stage for stage in stages if stage.name not in ORDER)}


@dataclass(frozen=True, kw_only=True)
class Telegraph(camsim.ElectronicStage):
    """A stage of one's own: traps in some photosites hold an electron or two."""

    name: ClassVar = "telegraph"
    stream: ClassVar = 1002
    temporal: ClassVar = True

    probability: float
    step_e: float

    def apply(self, electrons, context):
        """In each frame each photosite is up by a step, or not."""
        return electrons + self.step_e * (context.generator(self.stream).random(electrons.shape) < self.probability)

    def draws(self, shape, context):
        return shape[0] * shape[1]

    def dark_noise_e(self, electrons_per_dn):
        return self.step_e * math.sqrt(self.probability * (1.0 - self.probability))


def broken_variance(m, hot=0.02, theta=500.0 * TIME_S, dead=0.01):
    """Of a mixture: dead ones at 0, hot ones with an exponential charge on top of the mean m."""
    mean = (1 - dead) * m + hot * theta
    return (1 - dead - hot) * m**2 + hot * (m**2 + 2 * m * theta + 2 * theta**2) - mean**2


LAWS = {
    "prnu": Law(stage=camsim.Prnu(0.02), idle=camsim.Prnu(0.0), variance=lambda m: (0.02 * m) ** 2),
    "crosstalk": Law(
        stage=camsim.Crosstalk(KERNEL),
        idle=camsim.Crosstalk(((0, 0, 0), (0, 1, 0), (0, 0, 0))),
        mean=lambda m: 1.0 * m,
    ),
    "crosstalk with losses": Law(stage=camsim.Crosstalk(((0, 0.1, 0), (0, 0.7, 0), (0, 0, 0))), mean=lambda m: 0.8 * m),
    "dark current": Law(stage=camsim.DarkCurrent(60.0), idle=camsim.DarkCurrent(0.0), mean=lambda m: m + 15.0),
    "uneven dark current": Law(
        stage=camsim.DarkCurrent(60.0, nonuniformity=0.1), mean=lambda m: m + 15.0, variance=lambda m: 1.5**2
    ),
    "defects": Law(
        stage=camsim.Defects(hot_fraction=0.02, hot_e_per_s=500.0, dead_fraction=0.01),
        idle=camsim.Defects(),
        mean=lambda m: 0.99 * m + 0.02 * 125.0,
        variance=broken_variance,
    ),
    "shot noise": Law(stage=camsim.ShotNoise(), variance=lambda m: m),
    "blooming": Law(stage=camsim.Blooming(0.0), needs=(WELL,), mean=lambda m: min(m, 900.0)),
    "blooming with charge": Law(stage=camsim.Blooming(1.0), needs=(WELL,), mean=lambda m: min(m, 900.0)),
    "full well": Law(stage=WELL, idle=camsim.FullWell(1e15), mean=lambda m: min(m, 900.0)),
    "polynomial response": Law(
        stage=camsim.PolynomialResponse((-0.05, 0.01), 5000.0),
        idle=camsim.PolynomialResponse((0.0,), 5000.0),
        mean=lambda m: m * (1 - 0.05 * m / 5000.0 + 0.01 * (m / 5000.0) ** 2),
    ),
    "response table": Law(
        stage=camsim.ResponseTable((0.0, 5000.0), (0.0, 4500.0)),
        idle=camsim.ResponseTable((0.0, 1.0), (0.0, 1.0)),
        mean=lambda m: 0.9 * m,
    ),
    "reset noise": Law(
        stage=camsim.ResetNoise(16.0), idle=camsim.ResetNoise(0.0), variance=lambda m: 16.0**2, adds=True
    ),
    "read noise": Law(stage=camsim.ReadNoise(3.5), idle=camsim.ReadNoise(0.0), variance=lambda m: 3.5**2, adds=True),
    "read noise of Student": Law(
        stage=camsim.ReadNoise(3.5, student_dof=9.0),
        idle=camsim.ReadNoise(0.0, student_dof=9.0),
        variance=lambda m: 3.5**2,
        adds=True,
    ),
    "read noise of Tukey": Law(
        stage=camsim.ReadNoise(3.5, tukey_lambda=-0.05),
        idle=camsim.ReadNoise(0.0, tukey_lambda=-0.05),
        variance=lambda m: 3.5**2,
        adds=True,
    ),
    "uneven read noise": Law(
        stage=camsim.ReadNoise(3.5, spread=0.3),
        idle=camsim.ReadNoise(0.0, spread=0.3),
        variance=lambda m: 3.5**2,
        adds=True,
        patterned=True,
    ),
    "telegraph noise": Law(
        stage=camsim.TelegraphNoise(fraction=0.1, amplitude_e=12.0),
        idle=camsim.TelegraphNoise(fraction=0.1, amplitude_e=0.0),
        variance=lambda m: 0.1 * 2.0 * 6.0**2,
        adds=True,
        patterned=True,
    ),
    "dark frames": Law(
        stage=camsim.DarkFrames(codes_dn=np.random.default_rng(5).normal(0.0, 2.0, (5, 1000, 1000))),
        idle=camsim.DarkFrames(codes_dn=np.zeros((2, 3, 4))),
        variance=lambda m: 8.0**2,
        adds=True,
    ),
    "offset map": Law(
        stage=camsim.OffsetMap(offsets=np.random.default_rng(6).normal(0.0, 2.0, (1000, 1000)), unit="dn"),
        idle=camsim.OffsetMap(offsets=np.zeros((3, 4)), unit="dn"),
        variance=lambda m: 8.0**2,
        adds=True,
    ),
    "offset map before the gain": Law(
        stage=camsim.OffsetMap(offsets=np.random.default_rng(7).normal(0.0, 2.0, (1000, 1000)), unit="electrons"),
        idle=camsim.OffsetMap(offsets=np.zeros((3, 4)), unit="electrons"),
        variance=lambda m: 2.0**2,
        adds=True,
    ),
    "row noise": Law(
        stage=camsim.RowNoise(3.0), idle=camsim.RowNoise(0.0), variance=lambda m: 3.0**2, each="row", adds=True
    ),
    "flicker rows": Law(
        # Without a slope its rows know nothing of one another, as row noise's.
        stage=camsim.FlickerRows(2.0, exponent=0.0),
        idle=camsim.FlickerRows(0.0),
        variance=lambda m: 2.0**2,
        each="row",
        adds=True,
    ),
    "column noise": Law(
        stage=camsim.ColumnNoise(2.0), idle=camsim.ColumnNoise(0.0), variance=lambda m: 2.0**2, each="column", adds=True
    ),
    "DSNU": Law(stage=camsim.Dsnu(1.5), idle=camsim.Dsnu(0.0), variance=lambda m: 1.5**2, adds=True),
    "output noise": Law(
        stage=camsim.OutputNoise(0.7), idle=camsim.OutputNoise(0.0), variance=lambda m: 2.8**2, adds=True
    ),
}
OWN = {
    "a stage of one's own": Law(
        stage=Telegraph(probability=0.02, step_e=20.0),
        idle=Telegraph(probability=0.0, step_e=20.0),
        mean=lambda m: m + 0.4,
        variance=lambda m: 0.02 * 0.98 * 20.0**2,
        adds=True,
    )
}
EVERY = {law.stage.name: law.stage for law in reversed(LAWS.values()) if law.stage.name != "dark_frames"}
"""One example of every stage by the camera's names: the first of each above. Real darks stand in many others' place."""


def recorded(mean_electrons, *, noise=True, threads=None, **how):
    """``record`` with stages and circumstances by name, as a camera has them; without ``shot_noise=None`` it acts."""
    stages = Electronics(**{name: how.pop(name) for name in (*ORDER, "extra_stages") if name in how}).stages
    acting = tuple(stage for stage in stages if noise or stage.without_noise)
    return recorded_by(acting, mean_electrons, threads=threads, **how)


def recorded_by(stages, mean_electrons, *, threads=None, **how):
    return record(mean_electrons, stages, context(stages, np.shape(mean_electrons), **how), threads=threads)


def context(stages, shape, **how):
    """What stages may know of electrons of a shape (a margin included); all of it has a usual value."""
    margin = 2 * sum(stage.margin for stage in stages)
    usual = {"time_s": TIME_S, "electrons_per_dn": ELECTRONS_PER_DN, "seed": 7, "serial": 3, "origin": (0, 0)}
    usual |= {"frame_cols": shape[1] - margin, "rows_in_all": shape[0] - margin}
    return Context(**(usual | how))


class Spy:
    """Stands for ``streams.generator`` and keeps what is drawn, in order, by (seed, stream, block, frame number)."""

    def __init__(self, monkeypatch):
        self.drawn = {}
        self._true = streams.generator
        monkeypatch.setattr(streams, "generator", self)
        monkeypatch.setattr(streams, "_CACHED", {})
        monkeypatch.setattr(streams, "_MOST_CACHED", 0)  # each exposure draws all that it needs

    def __call__(self, seed, stream, *, block, frame_number=0, read_out=0):
        key = (seed, int(stream), block, frame_number, read_out)
        return _Watched(
            self._true(seed, stream, block=block, frame_number=frame_number, read_out=read_out),
            self.drawn.setdefault(key, []),
        )

    @property
    def numbers(self):
        return sum(np.size(numbers) for every in self.drawn.values() for numbers in every)


class _Watched:
    def __init__(self, rng, kept):
        self._rng, self._kept = rng, kept

    def __getattr__(self, verb):
        def draw(*args, **how):
            numbers = getattr(self._rng, verb)(*args, **how)
            self._kept.append(np.copy(numbers))
            return numbers

        return draw
