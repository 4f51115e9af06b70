"""The check: a few photosites of every image computed again, by another road."""
