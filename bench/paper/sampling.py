"""Why the paper's sampling here is further off than the paper's own program: ``python -m bench.paper.sampling``.

Five minutes on two cores; ``--quick`` leaves out the many samples. On the paper's square (f/8, with photosite) it
prints the errors of ``importance`` against the exact image for several radii R at which the Airy pattern is cut, over
the whole frame and over the window that ``make bench`` looks at, and then for other sets of samples at one radius.
Under "of it": largest and rms over those of the paper's own program on the frame. White is 1.

A pattern cut at R and normalised again gives (I − T)/(1 − β) in place of I: β is the pattern's light beyond R, about
2/π²R for R in λN, and T what of it falls on bright parts of the scene. With S = T/β, the mean of the scene beyond R as
the pattern weighs it, that is an error of β/(1 − β)·(I − S), whatever the samples:

beside a straight edge   ±β/2 at a distance that is more than a few λN and much less than R
inside a corner          −3β/4 likewise: the largest error of the square
the mean of the frame    minus the shadow that the whole pattern casts beyond the frame: all of it goes missing there,
                         and a cut pattern that does not reach beyond the frame puts it back within

"inf" samples are this formula, by quadrature of the boundary integral at every seventh photosite (of the window: every
second), taken as points.
"""

from __future__ import annotations

import argparse
import functools
import math
from collections.abc import Callable

import numba as nb
import numpy as np
from scipy.stats import qmc

import camsim
from bench.paper import cases, findings
from camsim.core.arrays import F64
from camsim.rendering.edges import Edges
from camsim.rendering.paper import rules
from camsim.rendering.paper.kernels import Steps, _covered
from tests.truth.rays import coverage_by_rays, rayleigh_energy

PSF = cases.PSFS["airy-f8-box"]
BLUR = float(PSF.blurs_px()[0])  # λN, pitches
CUTS = {"18 λN": 18.0, "45 λN": 45.0, "50 px": 50.0 / BLUR, "85 λN": 85.0, "200 λN": 200.0}
FEW, MANY = findings.PAPERS_PROGRAM["samples"], 14641
PAPERS_PROGRAM = {  # largest, rms of its frame; measured earlier
    FEW: (findings.PAPERS_PROGRAM["error_max"], findings.PAPERS_PROGRAM["error_rms"]),
    MANY: (3.1e-3, 1.3e-3),
}
FIRST = 20  # where the program's published source starts Halton's sequence
(X0, Y0), CORNERS = cases.frame().first_centre, cases.corners_px()
EDGES = Edges(start=CORNERS, end=np.roll(CORNERS, -1, axis=0), left=np.ones(4, int), right=np.zeros(4, int))
CONTRAST = np.full(4, -1.0)  # black on white
FRAME = slice(0, cases.SIZE), slice(0, cases.SIZE)
WINDOW = tuple(
    slice(first, first + count)
    for first, count in zip(cases.WINDOW_ORIGIN, (cases.WINDOW_ROWS, cases.WINDOW_COLS), strict=True)
)


def energy(r: F64 | float) -> F64:
    """Return the share of the pattern within r, λN."""
    return np.asarray(rayleigh_energy(r, 1.0))


@functools.lru_cache(maxsize=1)
def exact() -> F64:
    """Return the frame without sampling."""
    rendering = camsim.render(
        cases.square(), PSF.stages(), cases.frame(), wavelength_nm=cases.WAVELENGTH_NM, tolerance=1e-10
    )
    return np.asarray(rendering.image, float)


def by_samples(count: int, cut: float) -> F64:
    """Return the frame by camsim's ``importance``, cut elsewhere than at 18 λN."""
    places, shares = rules._importance(camsim.Airy(f_number=PSF.f_number), BLUR, count, cut)
    rule = rules.Rule(places=places, shares=shares, width=PSF.side_px, height=PSF.side_px)
    return rule.image(EDGES, CONTRAST, 1.0, origin=(X0, Y0), shape=(cases.SIZE, cases.SIZE))


def by_formula(cut: float, area: tuple[slice, ...], step: int) -> F64:
    """Return the errors that the cut alone makes, at every ``step``-th photosite of an area each way."""
    beyond = 1.0 - float(energy(cut))
    rows, cols = (np.arange(s.start, s.stop, step, dtype=float) for s in area)
    x, y = (places.ravel() for places in np.meshgrid(X0 + cols, Y0 + rows))

    def dark(of: Callable[[F64], F64]) -> F64:
        places = np.stack([x, y], axis=1)
        return np.array([coverage_by_rays(CORNERS, place, of, nodes=20, advance=1.5 * BLUR) for place in places])

    # Light lost to the square from beyond the cut, and in all; the image is 1 less the latter.
    far = dark(lambda r: np.maximum(energy(r / BLUR) - energy(cut), 0.0))
    whole = dark(lambda r: energy(r / BLUR))
    return (far - beyond * whole) / (1.0 - beyond)


@nb.njit(parallel=True)
def _turned(x0: float, y0: float, angles: F64, steps: Steps, side: float, places: F64) -> F64:
    """Render with the samples turned by an angle of each photosite's own."""
    image = np.empty(angles.shape)
    for r in nb.prange(angles.shape[0]):
        for c in range(angles.shape[1]):
            cosine, sine, total = math.cos(angles[r, c]), math.sin(angles[r, c]), 0.0
            for k in range(len(places)):
                left = x0 + c + cosine * places[k, 0] - sine * places[k, 1] - 0.5 * side
                top = y0 + r + sine * places[k, 0] + cosine * places[k, 1] - 0.5 * side
                total += _covered(left, top, side, side, steps)
            image[r, c] = 1.0 + total / len(places)
    return image


def sample_sets(cut: float) -> dict[str, tuple[F64, bool]]:
    """Return other points (n, 2) of the unit square, each with whether they turn from photosite to photosite."""
    within = float(energy(cut))
    halton = qmc.Halton(2, scramble=False).random(2 * FEW + FIRST)
    kept = halton[FIRST:][halton[FIRST:, 0] <= within][:FEW] / (within, 1.0)
    sets = {
        "Halton (2, 3) from 1, ours": (halton[1 : FEW + 1], False),
        f"the same from {FIRST}": (halton[FIRST : FEW + FIRST], False),
        "those beyond the cut drawn again": (kept, False),
        "and turned at every photosite": (kept, True),
        f"from {FEW}": (halton[FEW : 2 * FEW], False),
        "Halton (3, 2)": (halton[1 : FEW + 1, ::-1], False),
    }
    for seed in range(3):
        sets[f"scrambled, seed {seed}"] = qmc.Halton(2, seed=seed).random(FEW), False
    sets["random draws"] = np.random.default_rng(0).random((FEW, 2)), False
    return sets


def with_set(points: F64, cut: float, *, turning: bool) -> F64:
    """Return the frame with samples from points of the unit square: radius by table, angle."""
    rho = np.linspace(0.0, cut, 1 << 16)
    radius = BLUR * np.interp(points[:, 0] * energy(rho[-1:])[0], energy(rho), rho)
    turn = 2.0 * np.pi * points[:, 1]
    places = radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    angles = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi if turning else 0.0, (cases.SIZE, cases.SIZE))
    return _turned(X0, Y0, angles, Steps(EDGES.start, EDGES.end, CONTRAST), PSF.side_px, places)


def figures(errors: F64, count: int | None) -> str:
    """Return largest, rms and mean, and the first two over those of the paper's program with as many samples."""
    largest, rms = float(np.abs(errors).max()), math.sqrt(float(np.mean(errors**2)))
    theirs = PAPERS_PROGRAM.get(count or 0)
    ratios = f"{largest / theirs[0]:6.2f}{rms / theirs[1]:6.2f}" if theirs else f"{'–':>6}{'–':>6}"
    return f"{largest:10.2e}{rms:10.2e}{float(errors.mean()):+11.2e}{ratios}"


def heading(left: str) -> None:
    """Print the heads of a table."""
    columns = f"{'largest':>10}{'rms':>10}{'mean':>11}{'of it':>12}"
    print(f"\n{'':<35} | {'frame':<43} | window\n{left:<35} | {columns} | {columns}", flush=True)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=f"{FEW} samples only")
    counts = (FEW,) if parser.parse_args().quick else (FEW, MANY)
    truth = exact()
    within = float(np.sum(1.0 - truth))
    print(
        f"shadow beyond the frame: {(cases.SIDE_PX**2 - within) / cases.SIZE**2:.2e} of a photosite's white, on average"
    )
    heading(f"{'cut':<8}{'beyond':>9}{'2/π²R':>9}{'samples':>9}")
    for name, cut in CUTS.items():
        light = f"{name:<8}{1.0 - float(energy(cut)):9.2e}{2.0 / (np.pi**2 * cut):9.2e}"
        for count in counts:
            errors = by_samples(count, cut) - truth
            print(f"{light}{count:>9} | {figures(errors, count)} | {figures(errors[WINDOW], count)}", flush=True)
        limits = [figures(by_formula(cut, area, step), None) for area, step in ((FRAME, 7), (WINDOW, 2))]
        print(f"{light}{'inf':>9} | {' | '.join(limits)}", flush=True)
    heading(f"{FEW} samples, cut at 50 px")
    for name, (points, turning) in sample_sets(CUTS["50 px"]).items():
        errors = with_set(points, CUTS["50 px"], turning=turning) - truth
        print(f"{name:<35} | {figures(errors, FEW)} | {figures(errors[WINDOW], FEW)}", flush=True)


if __name__ == "__main__":
    main()
