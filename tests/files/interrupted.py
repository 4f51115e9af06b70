"""Run by test_whole_or_not.py: save over an old file again and again in children that are killed.

python interrupted.py FRAMES.pickle FOLDER KILLS prints, for each suffix, what was found after each kill.
"""

import hashlib
import json
import os
import pickle
import random
import signal
import sys
import time
from pathlib import Path

from camsim.files import SUFFIXES, save


def main(pickled: Path, folder: Path, kills: int) -> None:
    frames = pickle.loads(pickled.read_bytes())
    rng = random.Random(1)
    found: dict[str, list[str]] = {}
    for suffix in SUFFIXES:
        target = folder / f"a{suffix}"
        known = {}
        for name, frame in frames.items():
            began = time.perf_counter()
            save(frame, target, force=True)
            took = time.perf_counter() - began
            known[hashlib.sha256(target.read_bytes()).hexdigest()] = name
        found[suffix] = []
        for kill in range(kills):
            child = os.fork()
            if child == 0:
                while True:
                    for frame in frames.values():
                        save(frame, target, force=True)
            # The first is killed while it writes, however busy the machine is; the others at any moment.
            while kill == 0 and not any(path.suffix == ".part" for path in folder.iterdir()):
                pass
            time.sleep(rng.uniform(0, 3 * took) if kill else 0.0)
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            found[suffix].append(known.get(hashlib.sha256(target.read_bytes()).hexdigest(), "neither"))
    print(json.dumps(found))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
