"""Garbage collection for commands and workers."""

from __future__ import annotations

import gc

SELDOM = 20_000  # more objects made than freed, after which garbage is looked for


def look_in_new() -> None:
    """Look for garbage in what is made from here on, and seldom.

    Imports make a million objects that stay, scenes of many shapes hundreds of thousands, none of which is garbage.
    """
    gc.freeze()
    gc.set_threshold(SELDOM)
    gc.enable()
