"""Rendering of pictures: fields of samples, by their Fourier transforms (docs/pictures.md)."""
