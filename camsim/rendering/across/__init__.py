"""Lenses that are other ones elsewhere in the frame: places in tiles, and what lies between by interpolation."""
