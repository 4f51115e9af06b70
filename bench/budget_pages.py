"""The tables of error shares in docs/: ``python bench/budget_pages.py`` writes them from ``rendering/budget.py``."""

from __future__ import annotations

import re
from pathlib import Path

from camsim.rendering import budget

DOCS = Path(__file__).parents[1] / "docs"
TABLES = {"mathematics.md": {"scene": budget.SCENE, "boundary": budget.BOUNDARY, "frequencies": budget.FREQUENCIES}}


def written(text: str, tables: dict[str, dict[budget.Source, budget.Share]]) -> str:
    """Return a page with its tables made anew."""
    for name, shares in tables.items():
        rows = [f"| {source} | {share.model} | {share.part:.0%} |" for source, share in shares.items()]
        table = "\n".join(["| source of error | what bounds it | share |", "|---|---|---|", *rows])
        text, found = re.subn(
            rf"(<!-- budget {name} -->\n).*?(<!-- /budget -->)",
            lambda match, table=table: f"{match[1]}{table}\n{match[2]}",
            text,
            flags=re.DOTALL,
        )
        if found != 1:
            raise SystemExit(f"docs: {found} places for the table {name!r}, and there should be one")
    return text


if __name__ == "__main__":
    for page, tables in TABLES.items():
        path = DOCS / page
        path.write_text(written(path.read_text(encoding="utf-8"), tables), encoding="utf-8")
