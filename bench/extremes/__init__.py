"""Stiff and extreme cases: right to their tolerance, or refused with a reason; ``make extremes``."""
