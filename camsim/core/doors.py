"""The one way upward: methods that users look for on a class, and whose work is done on a higher floor.

Imports go down only. ``Camera.from_yaml`` reads YAML and ``Frame.save`` writes files, which know cameras and frames;
the classes reach them by name, when they are called. Where doors may lead is listed in
``tests/architecture/test_layers.py``.
"""

from __future__ import annotations

import importlib
from typing import Any


def above(place: str) -> Any:
    """Return what a place of a higher floor holds, such as ``api.load``; its module is loaded at the first call."""
    module, _, name = place.rpartition(".")
    return getattr(importlib.import_module(f"camsim.{module}"), name)
