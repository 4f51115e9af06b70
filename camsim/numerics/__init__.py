"""Quadrature, transforms and algebra: no camera in it."""
