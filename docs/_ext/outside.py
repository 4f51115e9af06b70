"""Files of the project's root that pages link to are pages of the site too, and links to scenes go to the gallery."""

from __future__ import annotations

from typing import Any

# As they are linked to from docs/*.md, and the page that includes the file.
PAGES = {"DATA_LICENSES.md": "data-licences.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}


def _linked(app: Any, name: str, source: list[str]) -> None:
    up = "../" * name.count("/")
    for file, page in PAGES.items():
        source[0] = source[0].replace(f"](../{up}{file}", f"]({up}{page}")


def setup(app: Any) -> dict[str, bool]:
    app.connect("source-read", _linked)
    return {"parallel_read_safe": True}
