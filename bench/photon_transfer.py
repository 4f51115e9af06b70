"""Photon transfer on every sensor: what goes into a profile comes back from its flats and darks.

    python bench/photon_transfer.py [NAME …] [--side 1000] [--frames 16]

``camsim measure noise --sensor NAME`` for each sensor that has noise. A figure passes when it is off by no more than
the larger of its tolerance and 4 σ of its estimator. One JSON line a channel goes to stdout, what fails to stderr;
exit code 1 when a figure fails.
"""

from __future__ import annotations

import argparse
import json
import math
import sys

import camsim
from camsim.api import load_camera
from camsim.config import library
from camsim.measure.noise import ChannelNoise, expected_of, measure_noise, take_shots

# Relative, of the larger of these and 4 σ; linearity in absolute terms.
TOLERANCES = {
    "gain_dn_per_e": 0.005,
    "read_noise_e": 0.01,
    "full_well_e": 0.005,
    "dark_current_e_per_s": 0.02,
    "dsnu_e": 0.02,
    "prnu": 0.02,
    "linearity_error": 0.001,
}


def failures(channel: ChannelNoise) -> list[str]:
    """Return a sentence for each figure that is off."""
    found = []
    for name, tolerance in TOLERANCES.items():
        estimate, expected = channel.figures()[name], (channel.expected or {})[name]
        if math.isnan(expected):
            continue
        if expected > estimate.at_most:
            found.append(f"{channel.channel} {name}: {expected:.6g} → at most {estimate.at_most:.2g}")
        if not estimate.measurable:
            continue
        relative = tolerance if name == "linearity_error" else tolerance * expected
        if abs(estimate.value - expected) > max(relative, 4.0 * estimate.sigma):
            found.append(f"{channel.channel} {name}: {expected:.6g} → {estimate.value:.6g} ± {estimate.sigma:.2g}")
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="sensors; all that have noise when left out")
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--frames", type=int, default=16)
    asked = parser.parse_args()
    failed = 0
    for name in asked.names or list(library.shipped("sensor")):
        camera = load_camera(name, lens=camsim.Airy(f_number=8.0))
        if camera.shot_noise is None:
            print(f"{name}: not measurable: it has no photon noise", file=sys.stderr)
            continue
        shots = take_shots(camera, side=asked.side, frames=asked.frames)
        report = measure_noise(shots, expected={letter: expected_of(camera, letter) for letter in shots.channels})
        for channel in report.channels:
            stated = channel.as_dict()
            line = {
                "sensor": name,
                **{key: stated[key] for key in ("channel", "photosites", "defects_left_out", "figures")},
            }
            print(json.dumps(line, ensure_ascii=False), flush=True)
            off = failures(channel)
            failed += len(off)
            for sentence in off or ["all figures pass"]:
                print(f"{name} {sentence}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
