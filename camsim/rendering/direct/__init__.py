"""The check: photosites computed again from the scene itself, the optics and the light, by direct sums."""
