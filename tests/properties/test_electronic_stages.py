"""Laws of every electronic stage, each through the chain; a new stage gets all of them by a line in ``electronics``."""

import copy
import dataclasses
import json

import numpy as np
import pytest
from electronics import ELECTRONS_PER_DN, EVERY, LAWS, OWN, Spy, context, fields_of, recorded, recorded_by
from tolerances import ROUNDING, STATISTICAL

import camsim
from camsim.camera.description import describe
from camsim.config import schema
from camsim.config.from_record import stages_from_record
from camsim.core.words import brief
from camsim.sensor.chain import random_numbers
from camsim.sensor.electronics import ORDER, Electronics
from camsim.sensor.stage import CUSTOM_STREAMS, Phase, streams_of

LIGHT = camsim.Light(line_nm=488.0, irradiance_w_per_m2=0.1)
EXPOSURE = camsim.Exposure(time_s=0.01, iso=100.0)
REGION = camsim.Region(rows=8, cols=8)
BY_CHANCE = camsim.Defects, camsim.TelegraphNoise
"""Chance decides how many photosites have them: their draws are not counted."""


@pytest.fixture(params=(LAWS | OWN).values(), ids=LAWS | OWN)
def law(request):
    return request.param


@pytest.fixture(params=LAWS.values(), ids=LAWS)
def listed(request):
    """A law of one of camsim's own."""
    return request.param


def wide(law, rows, cols):
    """The shape that the chain of a law takes to give (rows, cols)."""
    margin = sum(stage.margin for stage in law.chain)
    return rows + 2 * margin, cols + 2 * margin


def through(law, mean_electrons, **how):
    return recorded_by(law.chain, mean_electrons, **how)


def draws(law, shape):
    """Whether a stage draws numbers; of defects chance decides how many."""
    return isinstance(law.stage, BY_CHANCE) or law.stage.draws(shape, context(law.chain, shape)) > 0


def test_every_stage_has_a_law():
    assert {law.stage.name for law in LAWS.values()} == set(ORDER)


def test_every_stage_has_a_key():
    made = [mark.field for table in (schema.Charge, schema.Readout) for mark in marks_of(table)]
    assert sorted(made) == sorted([*ORDER, "dual_gain"])


def marks_of(table):
    for field in table.model_fields.values():
        yield from (mark for mark in field.metadata if isinstance(mark, schema.Makes))


def test_every_stage_has_a_stream_of_its_own():
    """For ever: a stage that took another's number would change old captures."""
    stages = {law.stage.name: law.stage for law in LAWS.values()}
    numbers = {name: streams_of(stage) for name, stage in stages.items() if stage.stream is not None}
    every = [number for item in numbers.values() for number in item]
    assert len(set(every)) == len(every)
    assert all(0 < number < CUSTOM_STREAMS for number in every)
    known = {"prnu": (1,), "shot_noise": (2,), "read_noise": (3, 12), "dsnu": (4,), "dark_current": (5,)}
    known |= {"reset_noise": (6,), "row_noise": (7,), "column_noise": (8,), "output_noise": (9,), "defects": (10,)}
    known |= {"flicker_rows": (11,), "telegraph_noise": (13, 14), "dark_frames": (15,)}
    assert numbers | known == numbers


def test_it_is_public_and_comes_back_from_its_description(listed):
    kind = type(listed.stage)
    assert getattr(camsim, kind.__name__) is kind
    if kind in (camsim.DarkFrames, camsim.OffsetMap):
        return  # of files: tests/measured/test_maps_of_photosites.py
    assert stages_from_record(json.loads(json.dumps(describe(listed.stage)))) == listed.stage


def test_the_facts_agree(law):
    stage = law.stage
    assert isinstance(stage, camsim.ElectronicStage)
    assert list(stage.phases) == sorted(set(stage.phases))
    assert not (stage.temporal and stage.stream is None)
    # What acts without noise draws nothing; what draws anew does so where neighbours of the window are gone.
    assert not (stage.without_noise and stage.stream is not None)
    assert not (stage.temporal and stage.phases[0] < Phase.CHARGE)


@pytest.mark.parametrize("shape", [(1, 1), (9, 1), (65, 3)])
def test_shape_and_type_stay(law, shape, rng):
    out = through(law, rng.uniform(0, 2000, wide(law, *shape)))
    assert out.shape == shape
    assert out.dtype == np.float64
    assert np.isfinite(out).all()


def test_the_input_is_not_touched(law, rng):
    electrons = rng.uniform(0, 2000, wide(law, 70, 30))
    before = electrons.copy()
    electrons.setflags(write=False)
    out = through(law, electrons)
    assert not np.shares_memory(out, electrons)
    out[:] = -1.0
    np.testing.assert_array_equal(electrons, before)


def test_seeds_decide_as_the_stage_says(law, rng):
    electrons = rng.uniform(100, 800, wide(law, 70, 30))
    first = through(law, electrons)
    np.testing.assert_array_equal(through(law, electrons), first)
    temporal = law.stage.temporal
    fixed = law.patterned or (draws(law, electrons.shape) and not temporal)
    for change, random in (({"seed": 8}, temporal), ({"frame_number": 1}, temporal), ({"serial": 4}, fixed)):
        assert np.array_equal(through(law, electrons, **change), first) != random, change


@pytest.mark.parametrize("rows", [1, 200])
def test_threads_change_no_byte(law, rows, rng):
    electrons = rng.uniform(0, 2000, wide(law, rows, 40))
    one, two, five = (through(law, electrons, threads=n).tobytes() for n in (1, 2, 5))
    assert one == two == five


def test_bands_are_the_whole(law, rng):
    electrons = rng.uniform(0, 2000, wide(law, 200, 40))
    whole = through(law, electrons)
    margin = 2 * sum(stage.margin for stage in law.chain)
    bands = ((0, 64), (64, 192), (192, 200))
    how = [{"rows_before": first, "rows_in_all": 200} for first, _ in bands]
    parts = [electrons[first : stop + margin] for first, stop in bands]
    if law.stage.whole_window:
        with pytest.raises(ValueError, match=f"{law.stage.name} runs over the whole window"):
            through(law, parts[0], **how[0])
        return
    joined = np.concatenate([through(law, part, **where) for part, where in zip(parts, how, strict=True)])
    np.testing.assert_array_equal(joined, whole)


@pytest.mark.parametrize("origin", [(1, 3), (64, 20), (159, 59)])
def test_a_window_is_that_slice_of_the_frame(law, origin, rng):
    """Of what belongs to the sensor; temporal noise belongs to the capture, and charge that runs to the window."""
    electrons = rng.uniform(0, 1200, wide(law, 200, 90))
    frame = through(law, electrons)
    (row, col), (rows, cols) = origin, wide(law, 41, 31)
    window = through(law, electrons[row : row + rows, col : col + cols], origin=origin, frame_cols=90)
    same = np.array_equal(window, frame[row : row + 41, col : col + 31])
    runs = isinstance(law.stage, camsim.Blooming) and law.stage.spill > 0.0
    if isinstance(law.stage, camsim.DarkFrames):
        assert same  # a dark lies where it was taken
    elif not law.stage.temporal and not runs:
        assert same
    else:
        assert not same


@pytest.mark.parametrize("origin", [(0, 0), (70, 11)])
def test_neighbours_that_give_nothing_shift_nothing(law, origin, rng):
    """With crosstalk the window is wider; each photosite keeps its pattern."""
    if law.stage.margin:
        return
    electrons = rng.uniform(0, 1200, (72, 42))
    straight = camsim.Crosstalk(((0, 0, 0), (0, 1, 0), (0, 0, 0)))
    chain = Electronics(**({"shot_noise": None} | fields_of(straight, *law.chain))).stages
    where = {"origin": origin, "frame_cols": 90}
    np.testing.assert_array_equal(recorded_by(chain, electrons, **where), through(law, electrons[1:-1, 1:-1], **where))


def test_the_stage_switched_off_takes_away_its_own_draws_alone(law, rng, monkeypatch):
    """Of a chain of every stage: the others' generators give the same numbers, one by one."""
    if isinstance(law.stage, camsim.DarkFrames):
        return  # there are few others beside it
    stages = EVERY | fields_of(law.stage)
    off = {"extra_stages": ()} if law.stage.name not in ORDER else {law.stage.name: None}
    if law.stage.name == "full_well":
        off["blooming"] = None  # it has nothing to spill over
    electrons = rng.uniform(0, 800, (132, 42))

    def drawn(stages):
        spy = Spy(monkeypatch)
        recorded(electrons if stages["crosstalk"] else electrons[1:-1, 1:-1], threads=1, **stages)
        monkeypatch.undo()
        return spy.drawn

    whole, without = drawn(stages), drawn(stages | off)
    item = {key for key in whole if key[1] in streams_of(law.stage)}
    assert bool(item) == draws(law, electrons.shape)
    assert set(without) == set(whole) - item
    # Photons follow the mean that they are given, and without crosstalk the window has no neighbours with patterns.
    others = {camsim.ShotNoise.stream}
    if law.stage.margin:
        others |= {stage.stream for stage in EVERY.values() if Phase.LIGHT in stage.phases}
    for key in without:
        if key[1] not in others:
            assert all(np.array_equal(a, b) for a, b in zip(without[key], whole[key], strict=True)), key


def test_mean_and_variance(law):
    """Over n independent numbers; the error of a variance by the fourth moment of what came out."""
    side = 600
    n = side * side if law.each == "photosite" else side
    for mean_e in (40.0, 5000.0):
        out = through(law, np.full(wide(law, side, side), mean_e))
        wanted_e, variance = law.mean(mean_e), law.variance(mean_e)
        off = out - wanted_e
        spread = np.sqrt(max(np.mean(off**4) - variance**2, 0.0) / n)
        rounding = ROUNDING * mean_e
        assert abs(off.mean()) <= STATISTICAL * np.sqrt(variance / n) + rounding
        assert abs(np.mean(off**2) - variance) <= STATISTICAL * spread + rounding**2


def test_the_dark_noise_is_what_dark_frames_have(law):
    """What stays from frame to frame is no noise."""
    side = 500
    n = side * side if law.each == "photosite" else side
    dark = [through(law, np.zeros(wide(law, side, side)), frame_number=number) for number in (0, 1)]
    square = (dark[0] - dark[1]) ** 2 / 2.0
    wanted = law.stage.dark_noise_e(ELECTRONS_PER_DN) ** 2
    assert abs(square.mean() - wanted) <= STATISTICAL * square.std() / np.sqrt(n)


@pytest.mark.parametrize("origin", [None, (100, 20)])
def test_the_count_is_what_generators_draw(law, origin, rng, monkeypatch):
    shape, how = ((200, 40), {}) if origin is None else ((70, 9), {"origin": origin, "frame_cols": 40})
    electrons = rng.uniform(0, 2000, wide(law, *shape))
    spy = Spy(monkeypatch)
    through(law, electrons, **how)
    counted = random_numbers(law.chain, shape, context(law.chain, electrons.shape, **how))
    assert counted == (0 if isinstance(law.stage, BY_CHANCE) else spy.numbers)


def test_more_light_never_gives_less(law):
    """For the same draws; a Poisson count is drawn anew at each mean: there the mean of many rises."""
    level = np.linspace(0.0, 2000.0, 41)
    steps = np.stack([through(law, np.full(wide(law, 30, 30), mean_e)) for mean_e in level])
    if isinstance(law.stage, camsim.ShotNoise):
        steps = steps.mean(axis=(1, 2))
    assert np.diff(steps, axis=0).min() >= 0.0


def test_a_stage_of_no_strength_does_nothing(law, rng):
    if law.idle is None:
        # There is no weak shot noise; but no charge makes none.
        assert law.mean(0.0) > 0.0 or (through(law, np.zeros(wide(law, 5, 5))) == 0.0).all() or law.adds
        return
    margin = sum(stage.margin for stage in law.chain)
    electrons = rng.uniform(0, 2000, wide(law, 70, 30))
    inside = electrons[margin : margin + 70, margin : margin + 30]
    np.testing.assert_allclose(recorded_by((law.idle,), electrons), inside, rtol=1e-15)


def test_frozen_and_equal_by_value(law):
    stage = law.stage
    assert copy.deepcopy(stage) == stage
    assert hash(copy.deepcopy(stage)) == hash(stage)
    for field in dataclasses.fields(stage):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(stage, field.name, 1.0)


def test_a_camera_has_it_and_says_so(law):
    fields = fields_of(*law.chain)
    camera = camsim.Camera.from_yaml("paper-488", lens=camsim.Airy(f_number=8.0)).replace(**fields)
    assert law.stage in camera.electronics(100.0)
    assert (law.stage in camera.electronics(100.0, noise=False)) == law.stage.without_noise
    assert camera.needs_whole_window == law.stage.whole_window
    frame = camera.expose(camsim.Scene(background=0.5), light=LIGHT, exposure=EXPOSURE, region=REGION)
    assert brief(law.stage) in frame.report.electronics
