"""The boundary engine: edges in closed form where the lens's pattern is round (docs/mathematics.md)."""
