"""The check: a few photosites of every image are recomputed by an independent method."""
