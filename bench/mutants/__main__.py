"""Whether the tests would notice: ``python bench/mutants`` changes one line of camsim at a time and runs its tests.

Mutants are drawn by kind and folder (``draw.py``); each gets the tests that run its line (``traced.py``, noted once in
out/mutants), in a copy of the project, until one fails. What comes out is appended to ``results.jsonl`` beside this
file, so that a run can be stopped and goes on where it was; survivors that change nothing stand with the reason in
``equivalent.jsonl``.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from draw import FOLDERS, ROOT, Mutant, drawn
from references import References
from report import RESULTS, reasons, results, table

LINES = ROOT / "out" / "mutants" / "lines.jsonl"
KERNEL_LINES = LINES.with_name("kernel-lines.jsonl")
BASELINE = ["tests/config/test_capture.py::test_frames_are_numbered_from_the_scenes_own"]
BASELINE_S, COMPILING_S = 1200.0, 600.0  # all kernels may have to be compiled; those that hold one line
KERNEL_TESTS = [
    *(f"tests/analytic/test_{name}.py" for name in ("rendering_truth", "crowd", "sampled")),
    "tests/measured/test_mtf_refusals.py",
]
EACH, SEED = 6, "1"


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench/mutants", description="Whether the tests notice one changed line.")
    parser.add_argument("--each", type=int, default=EACH, help=f"mutants of a kind from a folder ({EACH})")
    parser.add_argument("--seed", default=SEED, help=f"of the draw ({SEED})")
    parser.add_argument("--folders", default=",".join(FOLDERS), help="with commas between them")
    parser.add_argument("--most", type=float, default=60.0, help="seconds of tests for one mutant (60)")
    parser.add_argument("--again", action="store_true", help="try those that survived or never ended once more")
    parser.add_argument("--record", nargs="*", metavar="TESTS", help="only note which lines these tests run (all)")
    parser.add_argument("--interpreted", action="store_true", help="with --record: kernels as plain Python")
    parser.add_argument("--table", action="store_true", help="only show what came out")
    stated = parser.parse_args()
    mutants = [m for m in drawn(stated.each, stated.seed) if m.folder in stated.folders.split(",")]
    if stated.table:
        print(table(mutants))
    elif stated.record is not None:
        record(stated.record, interpreted=stated.interpreted)
    else:
        # In processes of their own: a mutant's must not find a camsim that is loaded already.
        for path, asked in ((LINES, []), (KERNEL_LINES, [*KERNEL_TESTS, "--interpreted"])):
            if not path.exists():
                subprocess.run([sys.executable, str(Path(__file__).parent), "--record", *asked], check=True)
        run(mutants, stated.most, stated.again)
        print(table(mutants))


def record(tests: list[str], *, interpreted: bool) -> None:
    """Run tests and note their lines; those of the same tests before are replaced.

    interpreted : kernels too, as plain Python; of tests for which twenty seconds are enough then
    """
    import pytest
    from traced import Recorder
    from trial import copy_tree, enter

    path = KERNEL_LINES if interpreted else LINES
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_suffix(".new")
    with tempfile.TemporaryDirectory() as folder:
        tree = copy_tree(Path(folder))
        enter(tree, interpreted)
        pytest.main(["-q", *tests], plugins=[Recorder(tree, new, most_s=20.0 if interpreted else 0.0)])
        os.chdir(ROOT)
    kept = {}
    for some in (path, new):
        for line in some.read_text(encoding="utf-8").splitlines() if some.exists() else []:
            kept[json.loads(line)["test"]] = line
    path.write_text("".join(f"{line}\n" for line in kept.values()), encoding="utf-8")
    new.unlink()


def run(mutants: list[Mutant], most_s: float, again: bool) -> None:
    """Try every mutant that has no result yet (``again``: and those that survived); a line each as they come."""
    from trial import Selection, changed, copy_tree, limit_s, preload, run_tests

    done = results()
    equivalent = reasons()
    references, plain = References(ROOT), References(ROOT, compiled=False)
    selection, of_kernels = Selection(LINES), Selection(KERNEL_LINES)
    for mutant in mutants:
        if done.get(mutant.key, {}).get("outcome") == "killed":
            selection.remember(mutant, done[mutant.key]["by"])
            of_kernels.remember(mutant, done[mutant.key]["by"])
    preload()
    sound: set[tuple[str, bool]] = set()
    with tempfile.TemporaryDirectory() as folder, RESULTS.open("a", encoding="utf-8") as file:
        tree = copy_tree(Path(folder))
        ended, by = run_tests(tree, BASELINE, BASELINE_S)
        if ended != "survived":
            raise SystemExit(f"without any mutant {by or 'the baseline'} fails ({ended}): {(tree / 'log').read_text()}")
        for mutant in mutants:
            before = done.get(mutant.key, {}).get("outcome")
            if before == "killed" or (before and (not again or mutant.key in equivalent)):
                continue
            began = time.monotonic()
            kernels = references.compiled_with(mutant.path, mutant.number)
            # Plain Python first, where nothing is compiled anew; what lives there is compiled after all.
            for interpreted in (True, False) if kernels else (False,):
                asked = of_kernels if interpreted else selection
                tests, expected_s = asked.of(mutant, plain if interpreted else references, most_s)
                limit = limit_s(expected_s) + (COMPILING_S if kernels and not interpreted else 0.0)
                while True:
                    outcome, by = "survived", ""
                    if tests:
                        with changed(tree, mutant):
                            outcome, by = run_tests(tree, tests, limit, interpreted=interpreted, compiled_anew=kernels)
                    if outcome != "killed" or (by, interpreted) in sound:
                        break
                    # What fails without the mutant too is no judge of it.
                    if run_tests(tree, [t for t in tests if t.startswith(by)], limit, interpreted=interpreted)[1]:
                        asked.forget(by)
                        tests = [test for test in tests if not test.startswith(by)]
                    else:
                        sound.add((by, interpreted))
                if outcome != "survived":
                    break
            line = {
                "key": mutant.key,
                "path": mutant.path,
                "kind": mutant.kind,
                "before": mutant.before.strip(),
                "after": mutant.after.strip(),
                "outcome": outcome,
                "by": by,
                "tests": len(tests),
                "seconds": round(time.monotonic() - began, 1),
            }
            print(json.dumps(line, ensure_ascii=False), file=file, flush=True)
            print(f"{outcome:8} {line['seconds']:6} s  {mutant.path}:{mutant.number} {mutant.kind}; {by}", flush=True)
            if outcome == "killed":
                asked.remember(mutant, by)


if __name__ == "__main__":
    main()
