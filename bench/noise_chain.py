"""The whole noise chain on 24 megapixels: time, memory beyond the frame, the same bytes on 1 and 2 threads.

python bench/noise_chain.py
"""

from __future__ import annotations

import hashlib
import json
import resource
import sys
import time

import numpy as np

import camsim
from camsim.sensor.chain import record
from camsim.sensor.electronics import Electronics
from camsim.sensor.stage import Context

ROWS, COLS = 4000, 6000
HERE = Context(time_s=0.01, seed=1, serial=1, origin=(0, 0), frame_cols=COLS, rows_in_all=ROWS)
# Every stage that acts on each photosite of an ordinary camera.
STAGES = {
    "prnu": camsim.Prnu(0.005),
    "dark_current": camsim.DarkCurrent(1.0, 0.1),
    "full_well": camsim.FullWell(40_000.0),
    "nonlinearity": camsim.PolynomialResponse((-0.005,), 40_000.0),
    "read_noise": camsim.ReadNoise(3.0),
    "row_noise": camsim.RowNoise(0.3),
    "column_noise": camsim.ColumnNoise(0.3),
    "dsnu": camsim.Dsnu(0.5),
    "output_noise": camsim.OutputNoise(0.5),
}
# Rarer ones: 3 × 3 crosstalk, the reset's noise, defects, bands.
ALL = STAGES | {
    "crosstalk": camsim.Crosstalk(((0, 0.01, 0), (0.01, 0.96, 0.01), (0, 0.01, 0))),
    "defects": camsim.Defects(hot_fraction=1e-5, hot_e_per_s=100.0, dead_fraction=1e-6),
    "reset_noise": camsim.ResetNoise(2.0),
    "flicker_rows": camsim.FlickerRows(0.2),
}


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e3 if sys.platform == "linux" else 1e6)


def main() -> None:
    for name, stages in (("usual", STAGES), ("all", ALL)):
        border = 2 * ("crosstalk" in stages)
        mean = np.tile(np.linspace(0.0, 45_000.0, COLS + border), (ROWS + border, 1))
        digests = set()
        for threads in (2, 1):
            before = peak_mb()
            begun, cpu = time.perf_counter(), time.process_time()
            electrons = record(mean, Electronics(**stages).stages, HERE, threads=threads)
            seconds, cpu = time.perf_counter() - begun, time.process_time() - cpu
            digests.add(hashlib.sha256(electrons.tobytes()).hexdigest())
            beyond_mb = peak_mb() - before - electrons.nbytes / 1e6
            line = {"stages": name, "megapixels": ROWS * COLS / 1e6, "threads": threads, "seconds": round(seconds, 2)}
            line |= {"cpu_seconds": round(cpu, 2)}
            print(json.dumps(line | {"mb_beyond_the_frame": round(max(beyond_mb, 0.0))}), flush=True)
            del electrons
        assert len(digests) == 1, "another number of threads, other bytes"
        print(json.dumps({"stages": name, "same_bytes_on_1_and_2_threads": True}))


if __name__ == "__main__":
    main()
