"""Lines of runs that never were, for what is computed from lines."""

from bench.results import FORMAT


def head(**changes):
    return {
        "kind": "run",
        "format": FORMAT,
        "quick": False,
        "started": "2026-01-01T00:00:00Z",
        "machine": {"processor": "one", "cores": 2},
        "versions": {"python": "3"},
        "threads": 2,
    } | changes


def load(cpu_s=0.02, *, busy=False):
    return {"kind": "load", "when": "before", "cpu_s": cpu_s, "wall_over_cpu": 2.0 if busy else 1.0, "busy": busy}


def machine(*, busy=False):
    return {"kind": "machine", "busy": busy, "sentence": "The machine was …."}


def point(method, label, error, seconds, *, psf="airy-f8-box", program="camsim", spread=0.02, **more):
    times = (
        {} if seconds is None else {"one_thread": {"wall_s": seconds, "cpu_s": seconds, "spread": spread, "laps": 7}}
    )
    return {
        "kind": "point",
        "psf": psf,
        "program": program,
        "method": method,
        "label": label,
        "error_max": error,
        "error_rms": error / 3,
        "error_mean": 0.0,
        "error_max_16bit": error,
        "error_rms_16bit": error / 3,
        "shifts": 25,
        **times,
        **more,
    }
