"""Wavelengths: curves, spectra and light, by name or by table."""
