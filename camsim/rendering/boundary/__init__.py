"""The boundary engine: edges in closed form for rotationally symmetric lenses (docs/mathematics.md)."""
