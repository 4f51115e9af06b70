"""Sensor and lens with scene and light: from what is irradiated to a frame of codes."""
