"""The intended key: by spelling, by synonym, or by its place elsewhere."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_args, get_origin

from camsim.config.expect import Expected, expected_of_field
from camsim.config.schema import SceneFile, SensorFile, Table
from camsim.config.tree import KeyPath, dotted
from camsim.core.words import meant


def elsewhere(key: str, root: type[Table], here: KeyPath) -> list[str]:
    """Return the other places of a format where a key of exactly this name belongs, as dotted paths, lists' last."""
    here = tuple(0 if isinstance(part, int) else part for part in here)
    places = dict.fromkeys(path for path in _all_keys(Expected.of(root), ()) if path[-1] == key)
    return [dotted(path) for path in sorted(places, key=lambda path: 0 in path) if path != here]


def place_of(word: str) -> str | None:
    """Return the key that a word means as ``--set`` has it, None when nothing is near.

    >>> place_of("tolerance"), place_of("shutter"), place_of("read-noise"), place_of("out")
    ('render.tolerance', 'exposure.time_s', 'sensor.readout.read_noise_e', None)
    """
    places = dict.fromkeys(_all_keys(Expected.of(SceneFile), ()))
    places |= dict.fromkeys(("sensor", *path) for path in _all_keys(Expected.of(SensorFile), ()))
    found = [path for path in places if 0 not in path]
    # Among a hundred names some are slightly similar to any word.
    name = meant(word, sorted({str(path[-1]) for path in found}), alike=0.8)
    return next((dotted(path) for path in found if path[-1] == name), None)


def _all_keys(expected: Expected, path: KeyPath, above: tuple[type[Table], ...] = ()) -> Iterator[KeyPath]:
    for table in expected.tables():
        for name, field in table.fields().items():
            yield (*path, name)
            inside = expected_of_field(field)
            if not {*inside.holds()} & {*above, table}:  # a group's shapes are listed once
                yield from _all_keys(inside, (*path, name), (*above, table))
    for alternative in expected.alternatives():
        if get_origin(alternative.kind) is list:
            yield from _all_keys(Expected.of(get_args(alternative.kind)[0]), (*path, 0), above)
