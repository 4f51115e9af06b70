"""Sensor and lens with scene and light: from radiance to a raw frame."""
