"""Lenses that are a round one, moved, and a short difference: one by an exact engine, the other where an edge is near."""
