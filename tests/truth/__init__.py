"""The only place of truths: what tests and the attack hold camsim to, by roads of their own.

Imports nothing of camsim: shapes, photosites and lenses come as plain dictionaries and numbers, so that nothing of what
is judged is asked what it means. Lengths are in any one unit, x to the right and y down.

picture       : painter's order by winding tests: the pieces of outline that are seen, and what lies on either side
boundary      : single photosites of a round lens, by line integrals over outline and photosite; any alignment
waves         : all photosites of any lens, by Fourier sums
pupils, round_lenses, photosites : what lenses and photosites are, from their definitions
sums          : sums of waves from any places, on even lattices
closed_forms  : what has a closed form or takes a single integral
electrons     : electrons of a surface in a light, from published tables
rays, quadrature : two more roads to photosites of a polygon under an Airy pattern, ray by ray and edge by edge
lattice       : all photosites of a polygon, at several wavelengths, places and footprints at once
"""
