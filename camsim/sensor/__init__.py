"""The sensor: photons to electrons to data numbers."""
