"""The tolerances of the tests, by name; nothing else decides how wrong a number may be."""

ROUNDING = 1e-12
"""Relative to white: float64 over sums of some hundred terms, for the same arithmetic in another order."""

METHOD = 2.0
"""Times the tolerance asked for: two renderings, each within it of the truth, differ by no more than that."""

STATISTICAL = 4.5
"""Standard deviations: one honest seed in 150 000 is farther off (seeds are fixed: always or never)."""

PROBABILITY = 7e-6
"""The same as the probability that a test of a whole distribution gives: both tails beyond 4.5 standard deviations."""
