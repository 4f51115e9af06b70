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
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from draw import FOLDERS, KINDS, ROOT, Mutant, drawn
from references import References

HERE = Path(__file__).parent
RESULTS = HERE / "results.jsonl"
EQUIVALENT = HERE / "equivalent.jsonl"
LINES = ROOT / "out" / "mutants" / "lines.jsonl"
EACH, SEED = 5, "1"


def main() -> None:
    parser = argparse.ArgumentParser(prog="bench/mutants", description="Whether the tests notice one changed line.")
    parser.add_argument("--each", type=int, default=EACH, help=f"mutants of a kind from a folder ({EACH})")
    parser.add_argument("--seed", default=SEED, help=f"of the draw ({SEED})")
    parser.add_argument("--folders", default=",".join(FOLDERS), help="with commas between them")
    parser.add_argument("--most", type=float, default=60.0, help="seconds of tests for one mutant (60)")
    parser.add_argument("--again", action="store_true", help="try those that survived once more")
    parser.add_argument("--record", nargs="*", metavar="TESTS", help="only note which lines these tests run (all)")
    parser.add_argument("--table", action="store_true", help="only show what came out")
    told = parser.parse_args()
    mutants = [m for m in drawn(told.each, told.seed) if m.folder in told.folders.split(",")]
    if told.record is not None or not (told.table or LINES.exists()):
        record(told.record or [])
    if told.record is None:
        if not told.table:
            run(mutants, told.most, told.again)
        print(table(mutants))


def record(tests: list[str]) -> None:
    """Run tests, all unless told otherwise, and note their lines; those of the same tests before are replaced."""
    import pytest
    from traced import Recorder
    from trial import copy_tree

    LINES.parent.mkdir(parents=True, exist_ok=True)
    new = LINES.with_suffix(".new")
    with tempfile.TemporaryDirectory() as folder:
        tree = copy_tree(Path(folder))
        os.chdir(tree)
        os.environ["PYTHONPATH"] = str(tree)
        sys.path.insert(0, str(tree))
        pytest.main(["-q", *tests], plugins=[Recorder(tree, new)])
        os.chdir(ROOT)
    kept = {}
    for path in (LINES, new):
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
            kept[json.loads(line)["test"]] = line
    LINES.write_text("".join(f"{line}\n" for line in kept.values()), encoding="utf-8")
    new.unlink()


def run(mutants: list[Mutant], most_s: float, again: bool) -> None:
    """Try every mutant that has no result yet (``again``: and those that survived); a line each as they come."""
    from trial import Selection, changed, copy_tree, limit_s, preload, run_tests

    done = results()
    equivalent = reasons()
    references, selection = References(ROOT), Selection(LINES)
    for mutant in mutants:
        if done.get(mutant.key, {}).get("outcome") == "killed":
            selection.remember(mutant, done[mutant.key]["by"])
    preload()
    with tempfile.TemporaryDirectory() as folder, RESULTS.open("a", encoding="utf-8") as file:
        tree = copy_tree(Path(folder))
        for mutant in mutants:
            before = done.get(mutant.key, {}).get("outcome")
            if before in ("killed", "timeout") or (before and (not again or mutant.key in equivalent)):
                continue
            began = time.monotonic()
            stale = references.compiled_with(mutant.path, mutant.number)
            tests, expected_s = selection.of(mutant, references, most_s)
            with changed(tree, mutant, stale):
                outcome, by = run_tests(tree, tests, limit_s(expected_s, bool(stale))) if tests else ("survived", "")
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
                selection.remember(mutant, by)


def results() -> dict[str, dict[str, object]]:
    """Return the last result of each mutant by its key."""
    lines = RESULTS.read_text(encoding="utf-8").splitlines() if RESULTS.exists() else []
    return {line["key"]: line for line in map(json.loads, lines)}


def reasons() -> dict[str, str]:
    """Return why mutants change nothing that could be tested, by key."""
    lines = EQUIVALENT.read_text(encoding="utf-8").splitlines() if EQUIVALENT.exists() else []
    return {line["key"]: line["reason"] for line in map(json.loads, lines)}


def table(mutants: list[Mutant]) -> str:
    """Return killed and all, by kind and folder, and every survivor with the reason, where there is one."""
    done, equivalent = results(), reasons()
    outcome = {mutant.key: done.get(mutant.key, {}).get("outcome", "not tried") for mutant in mutants}
    all_of, killed = Counter(), Counter()
    for mutant in mutants:
        for cell in ((mutant.folder, mutant.kind), (mutant.folder, ""), ("", mutant.kind), ("", "")):
            all_of[cell] += 1
            killed[cell] += outcome[mutant.key] in ("killed", "timeout")
    folders = [folder for folder in FOLDERS if all_of[folder, ""]]
    rows = [["", *folders, "all"]]
    for kind in (*KINDS, ""):
        cells = [f"{killed[where, kind]}/{all_of[where, kind]}" for where in (*folders, "")]
        rows.append([kind or "all", *("" if cell == "0/0" else cell for cell in cells)])
    text = "\n".join(f"{row[0]:20}" + "".join(f"{cell:>11}" for cell in row[1:]) for row in rows)
    ends = Counter(outcome.values())
    same = sum(outcome[mutant.key] == "survived" and mutant.key in equivalent for mutant in mutants)
    of_those = len(mutants) - same - ends["not tried"]
    dead = ends["killed"] + ends["timeout"]
    text += f"\n\n{dead} of {len(mutants)} killed ({ends['timeout']} by hanging), {ends['not tried']} not tried; "
    text += f"{same} survivors change nothing that could be tested: {100 * dead / max(of_those, 1):.1f} % of the others"
    for mutant in mutants:
        if outcome[mutant.key] == "survived":
            text += f"\n\n{mutant.key} {mutant.path}:{mutant.number}, {mutant.kind}"
            text += f"\n  - {mutant.before.strip()}\n  + {mutant.after.strip()}"
            text += f"\n  {equivalent.get(mutant.key, 'NO REASON')}"
    return text


if __name__ == "__main__":
    main()
