"""What the bench says of its figures: findings, comparisons, the load on the machine."""

import threading

import pytest

from bench.paper.compare import compared
from bench.paper.findings import findings
from bench.paper.running import RATIOS
from camsim.bench.machine import Spin, spin, words_of_load

from .lines import head, load, machine, point

GALSIM = "GalSim, folding_threshold 0.0002"


def said(lines, topic):
    return [f for f in findings(lines) if f["topic"] == topic]


def test_auto_is_called_fastest_where_it_is_and_nowhere_else():
    ours = [point("auto", "auto 1e-4", 5e-5, 0.010), point("auto", "auto 1e-8", 5e-9, 0.100)]
    theirs = [point("folding_threshold", GALSIM, 2e-6, 0.05, program="GalSim"), point("area", "area", 0.3, 0.001)]
    (found,) = said([head(), *ours, *theirs], "fastest")
    assert found["won"] == pytest.approx([1e-2, 1e-3, 1e-4, 1e-6, 1e-7, 1e-8])
    assert found["lost"] == pytest.approx([1e-5])
    assert found["unreached"] == pytest.approx([1e-9, 1e-10])
    assert f"at 1e-5 {GALSIM} takes 50 ms and auto 1e-8 100 ms" in found["sentence"]
    assert "1e-9 and less were not reached" in found["sentence"]
    slower = point("area", "area", 0.9e-9, 0.3)
    (found,) = said([head(), *ours, slower], "fastest")
    assert found["sentence"].endswith(
        "auto is the fastest at every error from 1e-2 to 1e-8; 1e-9 and less were not reached."
    )


def test_nothing_is_the_fastest_where_nothing_else_was_clocked():
    ours = point("auto", "auto 1e-4", 5e-5, 0.010)
    assert said([head(), ours], "fastest") == []
    assert said([head(), ours, point("area", "area", 0.3, None)], "fastest") == []


def test_the_timed_frame_counts_as_much_as_the_windows():
    ours = point("auto", "auto 1e-4", 5e-5, 0.01, error_frame_max=5e-3)
    (found,) = said([head(), ours, point("area", "area", 0.3, 0.02)], "fastest")
    assert found["won"] == pytest.approx([1e-2])


def test_a_ratio_is_taken_at_no_larger_an_error():
    lines = [
        head(),
        point("auto", "auto 1e-4", 5e-6, 0.01),
        point("auto", "auto 1e-6", 5e-7, 0.02),
        point("folding_threshold", GALSIM, 2e-6, 0.5, program="GalSim"),
    ]
    (found,) = said(lines, "peer")
    assert found["ours"] == "auto 1e-6"
    assert found["ratio"] == pytest.approx(25.0)


def run(points, **how):
    spin_s = how.get("spin_s", 0.02)
    return [head(), load(spin_s, busy=how.get("busy", False)), *points, machine(busy=how.get("busy", False))]


def topics(old, new):
    return [line["topic"] for line in compared(old, new)]


def test_slower_and_less_accurate_are_told_and_noise_is_not():
    old = run([point("auto", "auto 1e-4", 5e-5, 0.010), point("auto", "auto 1e-6", 5e-7, 0.020)])
    assert topics(old, old) == ["compared"]
    assert topics(old, run([point("auto", "auto 1e-4", 5.5e-5, 0.011)])) == ["compared"]
    assert topics(old, run([point("auto", "auto 1e-4", 5e-5, 0.013)])) == ["compared", "slower"]
    assert topics(old, run([point("auto", "auto 1e-4", 5e-5, 0.013, spread=0.2)])) == ["compared"]
    assert topics(old, run([point("auto", "auto 1e-4", 5e-5, 0.0125)], busy=True)) == ["compared"]
    assert topics(old, run([point("auto", "auto 1e-4", 9e-5, 0.010)])) == ["compared", "less accurate"]
    first, *_ = compared(old, run([point("auto", "auto 1e-4", 5e-5, 0.005)]))
    assert first["sentence"].startswith("1 settings compared: 0 slower, 1 faster, 0 less accurate; 1 of the older")


def test_a_slow_day_of_the_machine_is_no_fault_of_the_program():
    old = run([point("auto", "auto 1e-4", 5e-5, 0.010)])
    slow = run([point("auto", "auto 1e-4", 5e-5, 0.020)], spin_s=0.04)
    assert topics(old, slow) == ["compared"]
    assert "took 2.00 times as long" in next(iter(compared(old, slow)))["sentence"]
    assert topics(old, run([point("auto", "auto 1e-4", 5e-5, 0.020)])) == ["compared", "slower"]


def test_a_busy_machine_is_said():
    quiet, busy = Spin(cpu_s=0.02, wall_over_cpu=1.01), Spin(cpu_s=0.03, wall_over_cpu=1.9)
    assert words_of_load([quiet, quiet]) == "The machine was quiet."
    words = words_of_load([quiet, busy], RATIOS)
    assert "busy with other work at 1 of 2 looks" in words
    assert "ratios are taken from CPU times" in words
    assert "factor 1.50" in words


def test_the_spin_spins():
    found = spin(threads=1)
    assert found.cpu_s > 0.0
    assert found.wall_over_cpu > 0.9


def test_ctrl_c_before_every_core_spins_leaves_nobody_waiting(monkeypatch):
    begin, begun = threading.Thread.start, []

    def interrupted(thread):
        if begun:
            raise KeyboardInterrupt
        begun.append(thread)
        begin(thread)

    monkeypatch.setattr(threading.Thread, "start", interrupted)
    with pytest.raises(KeyboardInterrupt):
        spin(2)
    begun[0].join(60.0)
    assert not begun[0].is_alive()
