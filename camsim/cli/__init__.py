"""The command line: the only place that prints or exits."""

from __future__ import annotations


def main() -> None:
    """Run ``camsim`` with the arguments of the process, and exit."""
    from camsim.cli.app import run

    run()
