"""The command line: the only place that prints or exits."""

from __future__ import annotations


def main() -> None:
    """Run ``camsim`` with the arguments of the process, and exit."""
    import gc
    import os

    # Imports create a million permanent objects. Garbage collection of these, while they are created and again at exit,
    # takes 0.9 s; ``look_in_new`` enables the collector again.
    gc.disable()
    # OpenMP's workers otherwise spin for milliseconds after each loop: on a busy machine they spin on the very core
    # that the other half of the work waits for, and a rendering takes four times as long. Read when a loop first runs.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    # BLAS threads do too, for 26 ms after each matrix product.
    os.environ.setdefault("OPENBLAS_THREAD_TIMEOUT", "4")
    # Pydantic otherwise searches the metadata of all installed packages for plugins, which are not used here.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    from camsim.cli.app import run

    run()
