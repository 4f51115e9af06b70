"""Lenses that are a round one, moved, and a short difference: one in closed form, the other where an edge is near."""
