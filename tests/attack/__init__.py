"""A standing attack: random systems over everything that can be combined, each judged by ``tests.truth``.

``python -m tests.attack`` draws systems and judges camsim by them (docs/testing.md). A system is a plain dictionary,
drawn from a seed and a number alone; its lengths are in pitches.

draw    : seed and number → system        systems : system → camsim's objects, and the truth's
judge   : system → record: true error, estimate, tolerance, seconds, faults
"""
