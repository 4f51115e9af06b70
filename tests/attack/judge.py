"""One system rendered and judged: a record with the true error, the estimate, the time and what is wrong."""

import contextlib
import math
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

PATIENCE_S = 4.0  # of one processor's time, then a rendering, or a judge, is stopped: to be slow is no fault
QUICK_PATIENCE_S = 2.0  # the same of a quick attack
HONEST = 0.1  # the estimate may be no smaller than this part of an error over the tolerance
FINEST = 1e-11
ALL_AT_ONCE_S = 0.15  # so long Fourier sums judge every photosite of a frame
IN_ANY_CASE_S = 2.0  # the same where no other road is there
PLACES, PLACES_S = 6, 0.5  # photosites judged behind a lens that changes over the frame, and time for all but the first
LINES_S = 0.3  # for the photosites that line integrals judge, but the first
OTHER_S = 0.5  # that an engine is expected to take at a tenth of the tolerance
# Asked for less, both rules of the truth may agree on what is wrong: a curve's far light fades slowly.
LINES = {"airy": 1e-7, "annular": 1e-7, "gaussian": 1e-7, "curve": 1e-8}
AT_RANDOM = 8  # photosites judged by line integrals, besides those where closed forms change branch


def judged(seed, number, *, thorough=True, patience_s=PATIENCE_S):
    """Record of one system; ``thorough``: the truth where it takes seconds too; ``patience_s`` 0: wait for ever."""
    if not thorough:
        patience_s = min(patience_s, QUICK_PATIENCE_S)
    system = draw(seed, number)
    rng = np.random.default_rng([seed, number, 1])
    record = described(system, seed, number) | {"faults": []}
    begin = time.process_time()
    try:
        rendering = _rendered(system, patience_s)
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
    with (
        contextlib.suppress(Patience, UnsupportedError, InvalidValueError, AccuracyError),
        _at_most(patience_s),
    ):
        record |= _errors(system, rendering, rng, thorough)
    record["judge_seconds"] = time.process_time() - begin
    over = record["error"] - record["truth_error"] > system["tolerance"] * (1.0 + 1e-6)
    if over:
        record["faults"].append("over")
        if record["estimate"] < HONEST * record["error"]:
            record["faults"].append("silent")
    elif record["estimate"] > system["tolerance"] * (1.0 + 1e-6) and record["error"] < 0.3 * system["tolerance"]:
        record["faults"].append("alarm")
    return record


def described(system, seed, number):
    """What a record begins with."""
    return {
        "seed": seed, "number": number, "lens": system["lens"]["kind"], "photosite": system["photosite"]["kind"],
        "olpf": _olpf_name(system["olpf"]), "blur": system["lens"]["blur"], "tolerance": system["tolerance"],
        "asked": system["method"], "rows": system["grid"]["rows"], "cols": system["grid"]["cols"],
        "wavelengths": len(system["wavelength_nm"]), "shapes": len(system["shapes"]),
    }  # fmt: skip


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
        if global_compiler_lock.is_locked():  # a kernel that is being compiled is not torn apart, and costs nothing
            signal.setitimer(signal.ITIMER_PROF, seconds)
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
    elif (found := _by_waves(system, truth, image, planes, base, channel, thorough)) is not None:
        return found
    elif truth.round is not None:
        return _by_lines(system, truth, image, planes, base, channel, rng, thorough)
    return _by_the_other(system, truth, rendering)


def _by_places(system, truth, image, planes, base, channel, rng, thorough):
    """The steepest photosite, some at random and two corners, each by sums over its own pupil."""
    slopes = [np.abs(np.gradient(image, axis=axis)) for axis, count in enumerate(image.shape) if count > 1]
    some = rng.permutation(image.size).tolist()
    order = [int(np.argmax(sum(slopes, np.zeros(image.shape)))), *some[:2], 0, image.size - 1, *some[2:]]
    lens = systems.optics(system)[0]
    found = {"error": 0.0, "truth_error": 0.0, "judge": "nobody", "photosites_judged": 0}
    allowed = PLACES_S * (1.0 if thorough else 0.2)
    for place in list(dict.fromkeys(order))[:PLACES]:
        row, col = divmod(place, image.shape[1])
        c = int(channel[row, col])
        if planes is not None and rng.random() < 0.5:
            c = int(rng.integers(len(planes)))
        at = truth.x[col], truth.y[row]
        one = truth.placed(c, _digits(system))
        cost = one.cost(at)
        allowed -= cost
        if allowed < 0.0 and (found["photosites_judged"] or cost > IN_ANY_CASE_S):
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


def _digits(system):
    """Of Fourier sums: three more than the tolerance has."""
    return 3.0 - math.log10(system["tolerance"])


def _target(system):
    """Of line integrals."""
    return min(max(0.02 * system["tolerance"], 1e-13), LINES[system["lens"]["kind"]])


def _place(error):
    row, col = np.unravel_index(int(np.argmax(error)), error.shape)
    return {"row": int(row), "col": int(col)}


def _by_waves(system, truth, image, planes, base, channel, thorough):
    """Every photosite by Fourier sums; None where they take too long."""
    digits = _digits(system)
    allowed = ALL_AT_ONCE_S if not thorough else IN_ANY_CASE_S
    if truth.round is not None:
        allowed = min(allowed, max(ALL_AT_ONCE_S, 2.0 * truth.boundary(0, _target(system)).cost()))
    if truth.waves(0, digits).cost(truth.x, truth.y, len(base)) > allowed:
        return None
    worst = {"error": -1.0, "truth_error": 0.0}
    for c in range(len(base)):
        try:
            values, error = truth.waves(c, digits).values(truth.x, truth.y)
        except TooLarge:
            return None
        off = np.where(channel == c, np.abs(image - base[c] - values), 0.0)
        if planes is not None:
            off = np.maximum(off, np.abs(planes[c] - base[c] - values))
        if float(off.max()) > worst["error"]:
            worst = {"error": float(off.max()), "truth_error": error} | _place(off)
    return worst | {"judge": "waves", "photosites_judged": image.size}


def _by_lines(system, truth, image, planes, base, channel, rng, thorough):
    """Photosites that lie on something, the steepest, the last, and some at random."""
    target = _target(system)
    slopes = sum(np.abs(np.gradient(image, axis=axis)) for axis, count in enumerate(image.shape) if count > 1)
    steepest = [int(np.argmax(slopes))] if image.size > 1 else []
    order = [*_aligned(truth, rng), *steepest, image.size - 1, *rng.permutation(image.size)[:AT_RANDOM].tolist()]
    allowed, chosen = LINES_S * (1.0 if thorough else 0.2), {}
    for place in dict.fromkeys(order):
        c = int(channel.flat[place])
        allowed -= truth.boundary(c, target).cost()
        if allowed < 0.0 and chosen:
            break
        chosen.setdefault(c, []).append(place)
    worst = {"error": -1.0, "truth_error": 0.0, "photosites_judged": sum(map(len, chosen.values())), "judge": "lines"}
    for c, places in chosen.items():
        off, error = _off_lines(truth, image, planes, base, places, c, target)
        over = off - error > system["tolerance"]
        if np.any(over):  # the truth has to say that twice
            off[over], error[over] = _off_lines(truth, image, planes, base, np.array(places)[over], c, 1e-3 * target)
        k = int(np.argmax(off))
        if off[k] > worst["error"]:
            row, col = divmod(int(places[k]), image.shape[1])
            worst |= {"error": float(off[k]), "truth_error": float(error[k]), "row": row, "col": col}
    return worst


def _off_lines(truth, image, planes, base, places, c, target):
    """How far photosites of one channel are off, and the truth's own error."""
    rows, cols = np.divmod(places, image.shape[1])
    values, error = truth.boundary(c, target).values(np.stack([truth.x[cols], truth.y[rows]], axis=1))
    off = np.abs(image[rows, cols] - base[c] - values)
    if planes is not None:
        off = np.maximum(off, np.abs(planes[c, rows, cols] - base[c] - values))
    return off, error


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


def _by_the_other(system, truth, rendering):
    """What an engine makes of it at a tenth of the tolerance: no truth of its own, where no other takes moments."""
    channel, found = systems.channel(system), {"error": 0.0, "truth_error": 0.0, "photosites_judged": 0}
    tolerance = 0.1 * system["tolerance"]
    if tolerance < FINEST or systems.choice(system, tolerance=tolerance, method="auto").cost.seconds > OTHER_S:
        return found | {"judge": "nobody"}
    finer = systems.rendered(system, tolerance=tolerance, method="auto")
    worst = np.abs(rendering.image - finer.image) / truth.scale[channel]
    return found | {
        "judge": "finer", "error": float(worst.max()), "truth_error": tolerance, "photosites_judged": worst.size,
    } | _place(worst)  # fmt: skip
