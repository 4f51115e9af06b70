"""What came out of the mutants: how many were killed by kind and folder, and why the others live."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

from draw import FOLDERS, KINDS, Mutant

HERE = Path(__file__).parent
RESULTS = HERE / "results.jsonl"
EQUIVALENT = HERE / "equivalent.jsonl"


def results() -> dict[str, dict[str, str]]:
    """Return the last result of each mutant by its key."""
    lines = RESULTS.read_text(encoding="utf-8").splitlines() if RESULTS.exists() else []
    return {line["key"]: line for line in map(json.loads, lines)}


def reasons() -> dict[str, str]:
    """Return why mutants change nothing that a test could see, by key."""
    return {
        line["key"]: line["reason"] for line in map(json.loads, EQUIVALENT.read_text(encoding="utf-8").splitlines())
    }


def table(mutants: list[Mutant]) -> str:
    """Return killed and all by kind and folder, and every survivor with the reason, where there is one."""
    rows = _rows(mutants)
    text = "\n".join(f"{row[0]:20}" + "".join(f"{cell:>11}" for cell in row[1:]) for row in rows)
    text += f"\n\n{_in_words(mutants)}"
    for mutant, reason in _survivors(mutants):
        text += f"\n\n{mutant.key} {mutant.path}:{mutant.number}, {mutant.kind}"
        text += f"\n  - {mutant.before.strip()}\n  + {mutant.after.strip()}\n  {reason}"
    return text


def _rows(mutants: list[Mutant]) -> list[list[str]]:
    ended = _ended(mutants)
    all_of: Counter[tuple[str, str]] = Counter()
    killed: Counter[tuple[str, str]] = Counter()
    for mutant in (mutant for mutant in mutants if ended[mutant.key] != "not tried"):
        for cell in ((mutant.folder, mutant.kind), (mutant.folder, ""), ("", mutant.kind), ("", "")):
            all_of[cell] += 1
            killed[cell] += ended[mutant.key] in ("killed", "timeout")
    folders = [folder for folder in FOLDERS if all_of[folder, ""]]
    rows = [["killed of all", *folders, "all"]]
    for kind in (*KINDS, ""):
        cells = [f"{killed[where, kind]} of {all_of[where, kind]}" for where in (*folders, "")]
        rows.append([kind or "all", *("" if cell == "0 of 0" else cell for cell in cells)])
    return rows


def _in_words(mutants: list[Mutant]) -> str:
    ended, reason = _ended(mutants), reasons()
    count = Counter(ended.values())
    # What is marked as open is no reason: a test is still to be written.
    seen_by_none = {key for key, why in reason.items() if not why.startswith("OPEN")}
    same = sum(ended[mutant.key] == "survived" and mutant.key in seen_by_none for mutant in mutants)
    dead, tried = count["killed"] + count["timeout"], len(mutants) - count["not tried"]
    return (
        f"{dead} of {tried} mutants killed, {100 * dead / max(tried, 1):.1f} % ({count['timeout']} by never ending); "
        f"{same} of the survivors change nothing that a test could see: {100 * dead / max(tried - same, 1):.1f} % "
        f"of the others. {count['not tried']} not tried."
    )


def _survivors(mutants: list[Mutant]) -> list[tuple[Mutant, str]]:
    ended, reason = _ended(mutants), reasons()
    return [(mutant, reason.get(mutant.key, "NO REASON")) for mutant in mutants if ended[mutant.key] == "survived"]


def _ended(mutants: list[Mutant]) -> dict[str, str]:
    done = results()
    return {mutant.key: done[mutant.key]["outcome"] if mutant.key in done else "not tried" for mutant in mutants}
