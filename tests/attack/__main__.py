"""``python -m tests.attack``: draw systems, judge them, say what is wrong; exit code 1 when anything is."""

import argparse
import datetime
import json
import sys
import time
from pathlib import Path

from tests.attack import systems
from tests.attack.draw import draw
from tests.attack.judge import judged
from tests.attack.table import summary

WARM_UP = (2, 6, 10, 12, 22, 35, 43)
WRONG = {"over", "silent", "crash"}


def main(arguments=None):
    """Run; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack", description=__doc__)
    parser.add_argument("--seed", type=int, help="of the systems; left out: today's date, as 20261122")
    parser.add_argument("--count", type=int, default=100_000, help="how many systems")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--seconds", type=float, help="stop after so long, warm-up included")
    parser.add_argument("--quick", action="store_true", help="leave out truths that take seconds")
    parser.add_argument("--case", metavar="SEED:NUMBER", help="judge this one system and print it as Python")
    parser.add_argument("-o", "--output", type=Path, help="append a JSON line for every system here")
    options = parser.parse_args(arguments)
    if options.case:
        seed, number = (int(part) for part in options.case.split(":"))
        print(systems.code(draw(seed, number)))
        record = judged(seed, number)
        print(json.dumps(record, indent=1))
        return int(bool(WRONG & set(record["faults"])))
    seed = options.seed
    if seed is None:
        seed = int(datetime.date.today().strftime("%Y%m%d"))
    numbers, begin = range(options.first, options.first + options.count), time.perf_counter()
    for number in WARM_UP:
        judged(0, number, patience_s=0.0)  # kernels are compiled before anything is timed
    records = []
    for number in numbers:
        if options.seconds and time.perf_counter() - begin > options.seconds:
            break
        record = judged(seed, number, thorough=not options.quick)
        records.append(record)
        _keep(record, options.output)
        if record["faults"]:
            print(_line(record), flush=True)
    print(summary(records))
    return int(any(WRONG & set(record["faults"]) for record in records))


def _keep(record, output):
    if output:
        with output.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")


def _line(record):
    what = ", ".join(record["faults"])
    text = f"{record['seed']}:{record['number']} {what}: {record['lens']}, {record['photosite']}, {record['olpf']}"
    text += f", λN {record['blur']:.3g}, {record['rows']} × {record['cols']}"
    if "error" in record:
        text += (
            f", {record['method']}: asked {record['tolerance']:.2g}, error {record['error']:.2g} "
            f"(truth {record['truth_error']:.1g}, {record['judge']}), estimate {record['estimate']:.2g}"
        )
    return text + f", {record['seconds']:.1f} s" + ("\n" + record["crash"] if "crash" in record else "")


if __name__ == "__main__":
    sys.exit(main())
