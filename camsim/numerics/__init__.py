"""Quadrature, transforms and algebra, independent of cameras."""
