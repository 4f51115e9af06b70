"""The table that the tests of programs fill and pytest prints at its end."""

CELLS: dict[tuple[str, str], str] = {}


def note(row: str, column: str, words: str) -> None:
    """Remember what was found."""
    CELLS[row, column] = words


def lines() -> list[str]:
    """Return the table as Markdown, aligned."""
    rows = list(dict.fromkeys(row for row, _ in CELLS))
    columns = list(dict.fromkeys(column for _, column in CELLS))
    grid = [["file", *columns]]
    grid += [[row, *(CELLS.get((row, column), "") for column in columns)] for row in rows]
    widths = [max(len(line[k]) for line in grid) for k in range(len(grid[0]))]
    grid.insert(1, ["-" * width for width in widths])
    return ["| " + " | ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)) + " |" for line in grid]
