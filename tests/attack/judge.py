"""One system rendered and judged: a record with the true error, the estimate, the time and what is wrong."""

import contextlib
import signal
import time
import traceback
import warnings

import numpy as np
from numba.core.compiler_lock import global_compiler_lock

from camsim.errors import AccuracyError, InvalidValueError, UnsupportedError
from tests.attack import systems
from tests.attack.draw import draw
from tests.truth import field_lens
from tests.truth.pupils import TooLarge

PATIENCE_S = 25.0  # of one processor's time, then a rendering, or a judge, is stopped: to be slow is no fault
QUICK_S, QUICK_PATIENCE_S = 1.0, 3.0  # a quick attack sets aside what is expected to take longer, and its judges stop
QUICK_CHANGING = 1e-4  # tolerance of a lens that changes over the frame, from which it is quick
HONEST = 0.1  # the estimate may be no smaller than this part of an error over the tolerance
FINEST = {"boundary": 1e-11, "fourier": 1e-11}
ALL_AT_ONCE = 300  # points along the lattice's side: so far the Fourier sum judges every photosite
IN_ANY_CASE = 1000  # the same where no other road is there
PLACES, POINTS = 4, 3e6  # photosites judged behind a lens that changes over the frame, and lattices' points in all
EVALUATIONS = 3e7  # of line integrals: about a third of a second


def judged(seed, number, *, thorough=True, patience_s=PATIENCE_S):
    """Record of one system; ``thorough``: the truth where it takes seconds too; ``patience_s`` 0: wait for ever."""
    system = draw(seed, number)
    rng = np.random.default_rng([seed, number, 1])
    record = described(system, seed, number) | {"faults": []}
    begin = time.process_time()
    try:
        if not thorough and (expected := _expected_quick(system)) > QUICK_S:
            return record | {"set_aside": True, "expected": expected, "seconds": 0.0}
        try:
            rendering = _rendered(system, patience_s)
        except Patience:
            begin = time.process_time()
            rendering = _rendered(system, patience_s)  # the first may have met a kernel that was not compiled yet
    except (UnsupportedError, InvalidValueError, AccuracyError) as refused:
        return record | {"refused": f"{type(refused).__name__}: {refused}", "seconds": time.process_time() - begin}
    except Patience:
        return record | {"set_aside": True, "seconds": time.process_time() - begin}
    except Exception:
        record["faults"].append("crash")
        return record | {"crash": traceback.format_exc(limit=-3), "seconds": time.process_time() - begin}
    seconds = time.process_time() - begin
    record |= {"method": rendering.method, "seconds": seconds, "estimate": float(rendering.error_estimate)}
    begin = time.process_time()
    record |= {"error": 0.0, "truth_error": 0.0, "judge": "nobody"}
    with contextlib.suppress(Patience), _at_most(patience_s if thorough else min(patience_s, QUICK_PATIENCE_S)):
        record |= _errors(system, rendering, rng, thorough)
    record["judge_seconds"] = time.process_time() - begin
    over = record["error"] - record["truth_error"] > system["tolerance"] * (1.0 + 1e-6)
    if over:
        record["faults"].append("over")
        if record["estimate"] < HONEST * record["error"]:
            record["faults"].append("silent")
    elif record["estimate"] > system["tolerance"] * (1.0 + 1e-6) and record["error"] < 0.3 * system["tolerance"]:
        record["faults"].append("alarm")
    if "other" in record:
        record["faults"].append("other")
    return record


def described(system, seed, number):
    """What a record begins with."""
    return {
        "seed": seed, "number": number, "lens": system["lens"]["kind"], "photosite": system["photosite"]["kind"],
        "olpf": _olpf_name(system["olpf"]), "blur": system["lens"]["blur"], "tolerance": system["tolerance"],
        "asked": system["method"], "rows": system["grid"]["rows"], "cols": system["grid"]["cols"],
        "wavelengths": len(system["wavelength_nm"]), "shapes": len(system["shapes"]),
    }  # fmt: skip


def _expected_quick(system):
    """Seconds that it is expected to take; what is expected of lenses that change over the frame is far too much."""
    if system["lens"]["kind"] in systems.FIELD_LENSES and system["tolerance"] >= QUICK_CHANGING:
        return 0.0
    return systems.choice(system, tolerance=system["tolerance"], method=system["method"]).cost.seconds


def _rendered(system, patience_s):
    with warnings.catch_warnings(), _at_most(patience_s):
        warnings.simplefilter("error")
        return systems.rendered(system, every_channel=system["every_channel"])


class Patience(BaseException):
    """It takes too long."""


@contextlib.contextmanager
def _at_most(seconds):
    """Raise Patience once the process has computed for so long; 0: never."""

    def stop(number, frame):
        if global_compiler_lock.is_locked():  # a kernel that is being compiled is not torn apart
            signal.setitimer(signal.ITIMER_PROF, 1.0)
            return
        fired.append(number)
        raise Patience

    fired = []
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    except Exception as error:
        # Compiled code that was interrupted while it called Python raises an error of its own.
        if fired:
            raise Patience from error
        raise
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def _olpf_name(olpf):
    if olpf is None:
        return "none"
    plate = (
        "plate"
        if 0.0 in (olpf["split"], olpf["split_y"])
        else "four"
        if olpf["split"] == olpf["split_y"]
        else "unequal"
    )
    return plate + (" turned" if olpf["rotate_deg"] % 90.0 else "")


def _errors(system, rendering, rng, thorough):
    """The largest error over everything that was judged, relative to full scale, and who judged."""
    truth = systems.Truth(system)
    channel = systems.channel(system)
    image = rendering.image / truth.scale[channel]
    planes = None if rendering.planes is None else rendering.planes / truth.scale[:, None, None]
    base = truth.base / truth.scale
    if system["lens"]["kind"] in systems.FIELD_LENSES:
        found = _by_places(system, truth, image, planes, base, channel, rng, thorough)
        if found["photosites_judged"] or not thorough:
            return found
    elif (found := _by_waves(truth, image, planes, base, channel, thorough)) is not None:
        return found
    other = _by_the_other(system, truth, rendering.method)
    found = {"error": 0.0, "truth_error": 0.0, "judge": "nobody", "photosites_judged": 0}
    worst, is_round = np.zeros(image.shape), truth.round is not None
    if other is not None:
        method, tolerance, values = other
        worst = np.abs(image - values / truth.scale[channel])
        found |= {"error": float(worst.max()), "truth_error": tolerance, "judge": f"{method} at {tolerance:.1g}"}
        found |= _place(worst) | {"photosites_judged": image.size}
    if is_round:
        one = _by_lines(system, truth, image, planes, base, channel, worst, rng, thorough)
        # The truth judged the photosites that the other engine thought worst: it has the last word.
        if found["error"] - one["error"] > system["tolerance"]:
            one["other"] = f"{found['judge']} is {found['error']:.1g} off"
        found |= one
        found["judge"] = "lines" if other is None else "lines and the other engine"
    return found


def _by_places(system, truth, image, planes, base, channel, rng, thorough):
    """The steepest photosite, some at random and two corners, each by sums over its own pupil."""
    slopes = [np.abs(np.gradient(image, axis=axis)) for axis, count in enumerate(image.shape) if count > 1]
    some = rng.permutation(image.size).tolist()
    order = [int(np.argmax(sum(slopes, np.zeros(image.shape)))), *some[:2], 0, image.size - 1, *some[2:]]
    lens = systems.optics(system)[0]
    found = {"error": 0.0, "truth_error": 0.0, "judge": "nobody", "photosites_judged": 0}
    allowed = POINTS * (1.0 if thorough else 0.2)
    for place in list(dict.fromkeys(order))[:PLACES]:
        row, col = divmod(place, image.shape[1])
        c = int(channel[row, col])
        if planes is not None and rng.random() < 0.5:
            c = int(rng.integers(len(planes)))
        at = truth.x[col], truth.y[row]
        one = truth.placed(c)
        allowed -= one.cost(at)
        if allowed < 0.0:
            break
        value, error = one.value(at)
        displayed = image[row, col] if planes is None else planes[c, row, col]
        exposed = float(lens.illumination(np.array(system["pitch_um"] * np.hypot(*at))))
        right = base[c] + value
        off = max(
            abs(displayed - right), abs(exposed * displayed - field_lens.illumination(system["lens"], at) * right)
        )
        found |= {"judge": "places", "photosites_judged": found["photosites_judged"] + 1}
        if off - error >= found["error"] - found["truth_error"]:
            found |= {"error": float(off), "truth_error": error, "row": row, "col": col}
    return found


def _place(error):
    row, col = np.unravel_index(int(np.argmax(error)), error.shape)
    return {"row": int(row), "col": int(col)}


def _by_waves(truth, image, planes, base, channel, thorough):
    """Every photosite by Fourier sums; None where they ask for too large a lattice."""
    limit = ALL_AT_ONCE if truth.round is not None or not thorough else IN_ANY_CASE
    if truth.waves(0).points(truth.x, truth.y) > limit:
        return None
    worst = {"error": -1.0, "truth_error": 0.0}
    for c in range(len(base)):
        try:
            values, error = truth.waves(c).values(truth.x, truth.y)
        except TooLarge:
            return None
        off = np.where(channel == c, np.abs(image - base[c] - values), 0.0)
        if planes is not None:
            off = np.maximum(off, np.abs(planes[c] - base[c] - values))
        if float(off.max()) > worst["error"]:
            worst = {"error": float(off.max()), "truth_error": error} | _place(off)
    return worst | {"judge": "waves", "photosites_judged": image.size}


def _off_lines(truth, image, planes, base, place, target):
    """How far a photosite (row, column, channel) is off, and the truth's own error."""
    row, col, c = place
    value, error = truth.boundary(c, target).values([[truth.x[col], truth.y[row]]])
    off = abs(image[row, col] - base[c] - value[0])
    if planes is not None:
        off = max(off, abs(planes[c, row, col] - base[c] - value[0]))
    return float(off), float(error[0])


def _by_lines(system, truth, image, planes, base, channel, worst, rng, thorough):
    """The truth at photosites that the other engine finds worst, that lie on something, and at random."""
    # Asked for less, its two rules may agree on what is wrong: an annular lens at 5e-7 was 5e-5 off in both.
    target = min(max(0.02 * system["tolerance"], 1e-13), 1e-9)
    rows, cols = np.indices(image.shape)
    order = np.argsort(-worst, axis=None)[:4].tolist() if worst.any() else []
    order += _aligned(truth, rng)
    order += rng.permutation(image.size)[:8].tolist()
    order = list(dict.fromkeys(order))
    found = {"error": -1.0, "truth_error": 0.0, "photosites_judged": 0}
    spent, allowed = 0.0, EVALUATIONS * (1.0 if thorough else 0.2)
    for place in order:
        row, col = int(rows.flat[place]), int(cols.flat[place])
        c = int(channel[row, col])
        spent += truth.boundary(c, target).cost()
        if spent > allowed and found["photosites_judged"]:
            break
        off, error = _off_lines(truth, image, planes, base, (row, col, c), target)
        if off - error > system["tolerance"]:  # the truth has to say that twice
            off, error = _off_lines(truth, image, planes, base, (row, col, c), 1e-3 * target)
        found["photosites_judged"] += 1
        if off > found["error"]:
            found |= {"error": off, "truth_error": error, "row": row, "col": col}
    return found


def _aligned(truth, rng):
    """Photosites whose centre lies on an edge's line, those nearest its ends first; four edges."""
    y, x = np.meshgrid(truth.y, truth.x, indexing="ij")
    found = []
    straight = [p for p in truth.pieces if p.straight]
    for k in rng.permutation(len(straight))[:4]:
        a, b = np.array(straight[k].start), np.array(straight[k].end)
        e = (b - a) / np.hypot(*(b - a))
        height = (x - a[0]) * e[1] - (y - a[1]) * e[0]
        along = (x - a[0]) * e[0] + (y - a[1]) * e[1]
        length = float(np.hypot(*(b - a)))
        beyond = np.maximum(-along, along - length)
        foot = np.minimum(np.abs(along), np.abs(along - length))
        for hit in (np.abs(height) < 1e-6, foot < 1e-6):
            places = np.flatnonzero(hit)
            if places.size:
                found.append(int(places[np.argmin(np.abs(beyond.flat[places]))]))
                found.append(int(rng.choice(places)))
    return found


def _by_the_other(system, truth, method):
    """What another engine makes of it at a tenth of the tolerance; the same engine where there is no other."""
    names = [n for n in ("boundary", "fourier") if n != method] + [method]
    for name in names:
        tolerance = max(0.1 * system["tolerance"], FINEST[name])
        if tolerance > 0.5 * system["tolerance"]:
            continue
        try:
            # The truth judges round lenses in any case, the other engine where it takes a moment.
            expected = systems.choice(system, tolerance=tolerance, method=name).cost.seconds
            if expected > (0.5 if truth.round is not None else 5.0):
                continue
            return name, tolerance, systems.rendered(system, tolerance=tolerance, method=name).image
        except (UnsupportedError, InvalidValueError, AccuracyError):
            continue
    return None
