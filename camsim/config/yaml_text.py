"""A tree as YAML text, for people to read."""

from __future__ import annotations

from typing import Any


def yaml_text(tree: Any) -> str:
    """Return plain dicts, lists and scalars as YAML, keys in their order, without breaking lines.

    >>> print(yaml_text({"kind": "Airy", "f_number": 8.0, "name": "4.88 µm"}), end="")
    kind: Airy
    f_number: 8.0
    name: 4.88 µm
    """
    import yaml  # not before it is needed: every other command does without

    text: str = yaml.safe_dump(tree, sort_keys=False, allow_unicode=True, width=1000)
    return text
