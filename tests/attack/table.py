"""What an attack found, as a table."""

import math
from collections import Counter


def summary(records):
    """Count and worst of every kind of lens, who judged, what was set aside, then the faults."""
    if not records:
        return "nothing was judged"
    lines = [
        f"{'lens':<10} {'systems':>7} {'refused':>7} {'aside':>7} {'median':>9} {'worst':>9} {'slowest':>8}"
        "  error over tolerance"
    ]
    for lens in sorted({r["lens"] for r in records}):
        one = [r for r in records if r["lens"] == lens]
        ratios = sorted(r["error"] / r["tolerance"] for r in one if r.get("error", -1.0) >= 0.0)
        median = ratios[len(ratios) // 2] if ratios else math.nan
        worst = ratios[-1] if ratios else math.nan
        slowest = max(r["seconds"] for r in one)
        refused, aside = sum("refused" in r for r in one), sum("set_aside" in r for r in one)
        lines.append(f"{lens:<10} {len(one):>7} {refused:>7} {aside:>7} {median:>9.2g} {worst:>9.2g} {slowest:>6.1f} s")
    judges = Counter(r.get("judge", "set aside" if "set_aside" in r else "refused").split(" at ")[0] for r in records)
    lines.append("judged by: " + ", ".join(f"{name} {count}" for name, count in judges.most_common()))
    faults = Counter(fault for r in records for fault in r["faults"])
    lines.append("faults: " + (", ".join(f"{name} {count}" for name, count in faults.most_common()) or "none"))
    return "\n".join(lines)
