"""Random systems; everything is drawn from (seed, number); lengths in pitches.

Nine in ten are such as people take: tolerances of 1e-2 … 1e-6, blurs of 0.3 … 5 pitches, frames of 16² … 96², scenery
to ten frames away (without end behind round lenses), and wavefronts as steep as a lens may have there. Every tenth lies
beyond, and is right or refused.

Most coordinates lie on multiples of a quarter pitch in some share of the systems, because photosites on edges, on
corners and straight off an edge's end are where closed forms change branch.
"""

import math

import numpy as np

from tests.attack.drawings import add_drawings
from tests.attack.field_lenses import add_field_lens
from tests.attack.fields import add_fields
from tests.attack.moved import add_large_field, add_tilt, add_wide_olpf
from tests.examples import tile_centres
from tests.truth import pupils

REFERENCE_NM = 550.0
WAVELENGTHS = 4  # at most, behind wavefronts
PITCHES_UM = (1.0, 4.0, 4.88, 2.4)  # two of them keep multiples of a quarter exact
BEYOND = 10  # every so many lies beyond what people take
DIGITS, BLUR, SIDES = (2.0, 6.0), (0.3, 5.0), (16.0, 96.0)
DIGITS_BEYOND, BLUR_BEYOND = (2.0, 11.0), (0.02, 50.0)
ROUND = ("airy", "annular", "gaussian")  # scenery without end lies behind these
RECTANGLES = ("point", "square", "rectangle")  # the photosites that the boundary engine knows
STRAIGHT_DIGITS = 5.0  # the finest tolerance behind pupils with straight sides
STEEP_DIGITS = 4.0  # up to which wavefronts of many waves are kept
WAVES = {"circular": (2.0, 15.0), "square": (1.0, 5.0), "bladed": (1.0, 5.0)}  # rms at most: at any tolerance, and then
ORDER = 8
NODES = 32  # over the opening


def draw(seed, number):
    """One system."""
    rng = np.random.default_rng([seed, number])
    beyond = number % BEYOND == BEYOND - 1
    blur = float(10.0 ** rng.uniform(*np.log10(BLUR_BEYOND if beyond else BLUR)))
    rows, cols = _few(rng, blur) if beyond else _sides(rng)
    lens = _lens(rng, blur)
    wavelength_nm, response, layout = _spectrum(rng, lens)
    system = {
        "seed": seed,
        "number": number,
        "beyond": beyond,
        "pitch_um": float(rng.choice(PITCHES_UM)),
        "grid": _grid(rng, rows, cols),
        "lens": lens,
        "olpf": _olpf(rng),
        "photosite": _photosite(rng),
        "wavelength_nm": wavelength_nm,
        "response": response,
        "layout": layout,
        "tolerance": float(10.0 ** -rng.uniform(*(DIGITS_BEYOND if beyond else DIGITS))),
        "method": _method(rng, lens),
        "every_channel": bool(rng.random() < 0.2),
    }
    spectral = len(wavelength_nm) > 1 and rng.random() < 0.7

    def paint(rng):
        return _surface(rng, spectral)

    def curves(rng, size):
        return _curves(rng, size, spectral)

    system["background"] = paint(rng)
    system["shapes"] = _scene(rng, rows, cols, spectral, lens["kind"] in ROUND)
    size = max(rows, cols, 4)
    if number % 4 == 3:
        system["shapes"] = _with_curves(rng, system["shapes"], size, spectral)
    kind = (number // BEYOND) % 10  # of each ten of the ones within, and of those beyond
    if kind in (1, 6):
        add_fields(rng, system, paint, curves)
    elif kind == 2:
        add_field_lens(rng, system, curves)
    elif kind == 3:
        add_drawings(rng, system, _plain, paint)
    elif kind == 4:
        system["shapes"] = [*_tiles(rng, size), *system["shapes"]]
    elif kind == 5:
        (add_tilt, add_wide_olpf, add_large_field)[rng.integers(3)](rng, system, paint, curves)
    if not beyond:
        _within(system)
    return system


def _within(system):
    """Make engine, tolerance and wavefront such as are kept: many waves and straight sides ask for fewer digits."""
    lens = system["lens"]
    if system["photosite"]["kind"] not in RECTANGLES and system["method"] == "boundary":
        system["method"] = "auto"
    if lens["kind"] != "wavefront":
        return
    shape = lens["pupil"]["shape"]
    if shape != "circular":
        system["tolerance"] = max(system["tolerance"], 10.0**-STRAIGHT_DIGITS)
    most = WAVES[shape][int(system["tolerance"] >= 10.0**-STEEP_DIGITS)]
    waves = _waves(lens, min(system["wavelength_nm"]))
    if waves > most:
        lens["zernike_waves"] = [[j, c * most / waves] for j, c in lens["zernike_waves"]]
        lens["defocus_waves"] *= most / waves


def _waves(lens, wavelength_nm):
    """Root mean square over the opening, of which the corners of a square reach far beyond the unit circle."""
    pupil = lens["pupil"]
    levels, weight, begin, end = pupils.rows_of(pupil, NODES).T[:, :, None]
    t, w = pupils.gauss(NODES)
    x = 0.5 * (begin + end) + 0.5 * (end - begin) * t
    share = weight * 0.5 * (end - begin) * w / pupils.area(pupil)
    item = {
        "zernike_waves": [term for term in lens["zernike_waves"] if term[0] > 2],  # a tilt moves the image only
        "reference_nm": REFERENCE_NM, "f_number": 1.0, "defocus_um": lens["defocus_waves"] * REFERENCE_NM * 8e-3,
    }  # fmt: skip
    each = pupils.waves(item, x, levels, wavelength_nm)
    mean = float(np.sum(share * each))
    return math.sqrt(float(np.sum(share * (each - mean) ** 2)))


def _tiles(rng, size):
    """Squares side by side, of any greys or of two in turns: corners of turned ones differ in their last bits."""
    rows, cols = rng.integers(2, 5, 2).tolist()
    step, centre = float(rng.uniform(0.2, 0.6)) * size, rng.uniform(-0.3, 0.3, 2) * size
    rotate_deg = float(90.0 * rng.integers(4) + rng.choice([rng.uniform(-1.0, 1.0), rng.uniform(0.0, 90.0)]))
    greys = rng.random((rows, cols))
    if rng.random() < 0.5:
        rows, cols = rng.integers(3, 10, 2).tolist()
        step *= float(rng.uniform(0.2, 1.0))
        greys = rng.random(2)[np.indices((rows, cols)).sum(axis=0) % 2]
    centres = tile_centres((rows, cols), step, centre, rotate_deg).reshape(-1, 2)
    return [
        _rectangle(step, step, place, rotate_deg) | {"reflectance": grey}
        for place, grey in zip(centres.tolist(), greys.ravel().tolist(), strict=True)
    ]


def _rectangle(width, height, centre, rotate_deg):
    place = [float(v) for v in centre]
    return {
        "kind": "rectangle",
        "width": float(width),
        "height": float(height),
        "centre": place,
        "rotate_deg": rotate_deg,
    }


def _polygon(points):
    return {"kind": "polygon", "points": [[float(a), float(b)] for a, b in points]}


def _sides(rng):
    """Rows and columns."""
    return tuple(round(10.0 ** rng.uniform(*np.log10(SIDES))) for _ in range(2))


def _few(rng, blur):
    """Rows and columns: few where the pattern is sharp, in most systems, for time goes with (size/λN)²."""
    most = int(rng.choice([4, 8, 16, 32, 64], p=[0.5, 0.3, 0.12, 0.05, 0.03]))
    if blur < 0.2 and rng.random() < 0.9:
        most = min(most, 6)
    return int(rng.integers(1, most + 1)), int(rng.integers(1, most + 1))


def _grid(rng, rows, cols):
    if rng.random() < 0.75:
        return {"rows": rows, "cols": cols, "origin": [0, 0], "frame": None}
    frame = [rows + int(rng.integers(0, 30)), cols + int(rng.integers(0, 30))]
    origin = [int(rng.integers(0, frame[0] - rows + 1)), int(rng.integers(0, frame[1] - cols + 1))]
    return {"rows": rows, "cols": cols, "origin": origin, "frame": frame}


def _method(rng, lens):
    edges = 0.2 if lens["kind"] in (*ROUND, "curve") else 0.0
    return str(rng.choice(["auto", "boundary", "fourier"], p=[0.8 - edges, edges, 0.2]))


def _lens(rng, blur):
    """``blur``: λN at 550 nm in pitches, or what stands for it."""
    kinds = ["airy", "annular", "gaussian", "ellipse", "curve", "wavefront", "measured"]
    kind = str(rng.choice(kinds, p=[0.4, 0.1, 0.07, 0.07, 0.08, 0.23, 0.05]))
    lens = {"kind": kind, "blur": blur}
    if kind == "annular":
        lens["obstruction"] = float(rng.choice([0.05, 0.2, 0.33, 0.5, 0.7, 0.9, rng.uniform(0.02, 0.95)]))
    if kind == "ellipse":
        lens |= {"ratio": float(10.0 ** rng.uniform(0.0, 1.2)), "rotate_deg": _angle(rng)}
    if kind == "curve":
        count = int(rng.integers(3, 12))
        inner = (
            np.sort(rng.uniform(0.03, 0.97, count - 2)) if rng.random() < 0.5 else np.arange(1, count - 1) / (count - 1)
        )
        values = np.clip(1.0 - inner + rng.normal(0.0, rng.choice([0.0, 0.1, 0.3]), count - 2), -1.0, 1.0)
        lens |= {"frequency": [0.0, *inner.tolist(), 1.0], "values": [1.0, *values.tolist(), 0.0]}
    if kind == "wavefront":
        lens |= _wavefront(rng)
    if kind == "measured":
        n, m = (int(v) for v in rng.integers(3, 25, 2))
        y, x = np.mgrid[:n, :m]
        blob = np.exp(-(((x - 0.5 * m) / rng.uniform(1, 4)) ** 2) - ((y - 0.45 * n) / rng.uniform(1, 4)) ** 2)
        blob += rng.choice([0.0, 0.01]) * rng.normal(size=(n, m))
        lens["irradiance"] = (blob + 1e-3).tolist()
    return lens


def _wavefront(rng):
    """A pupil, and a few terms of orders to 8, as many as two in five times one term alone, which mixtures hide."""
    shape = str(rng.choice(["circular", "square", "bladed"], p=[0.6, 0.2, 0.2]))
    pupil = {"shape": shape, "obstruction": 0.0, "blades": 0, "rotate_deg": 0.0}
    if shape == "bladed":
        pupil["blades"] = int(rng.integers(3, 10))
    if shape != "circular":
        pupil["rotate_deg"] = _angle(rng)
    if rng.random() < 0.3:
        inner = math.cos(math.pi / pupil["blades"]) if shape == "bladed" else 1.0
        pupil["obstruction"] = float(rng.uniform(0.05, 0.9)) * inner
    count = int(rng.choice([0, 1, 2, 4], p=[0.2, 0.4, 0.2, 0.2]))
    strength = rng.choice([0.02, 0.1, 0.3, 1.0], p=[0.2, 0.4, 0.25, 0.15])
    indices = sorted(set(rng.integers(1, (ORDER + 1) * (ORDER + 2) // 2, count).tolist()))
    waves = [[int(index), float(strength * rng.normal())] for index in indices]
    defocus_waves = float(rng.choice([0.0, 0.0, rng.normal(), 8.0 * rng.normal()], p=[0.4, 0.3, 0.2, 0.1]))
    return {"pupil": pupil, "zernike_waves": waves, "defocus_waves": defocus_waves}


def _angle(rng):
    return float(rng.choice([0.0, 0.0, 45.0, 90.0, 30.0, rng.uniform(0.0, 180.0)]))


def _olpf(rng):
    kind = rng.choice(["none", "four", "unequal", "plate"], p=[0.4, 0.25, 0.1, 0.25])
    if kind == "none":
        return None
    split = float(rng.choice([0.5, 0.75, 1.0, rng.uniform(0.02, 1.5)]))
    other = {"four": split, "unequal": float(rng.uniform(0.0, 1.5)), "plate": 0.0}[str(kind)]
    if kind == "plate" and rng.random() < 0.3:
        split, other = other, split
    return {"split": split, "split_y": other, "rotate_deg": _angle(rng)}


def _photosite(rng):
    kind = str(
        rng.choice(
            ["point", "square", "rectangle", "circle", "rounded", "polygon"], p=[0.2, 0.4, 0.2, 0.07, 0.06, 0.07]
        )
    )
    sides = [float(rng.choice([1.0, 0.5, 0.75, rng.uniform(0.05, 1.2)])) for _ in range(2)]
    if kind == "square":
        return {"kind": kind, "side": sides[0]}
    if kind == "rectangle":
        return {"kind": kind, "width": sides[0], "height": sides[1]}
    if kind == "circle":
        return {"kind": kind, "diameter": sides[0]}
    if kind == "rounded":
        radius = float(rng.uniform(0.0, 0.5)) * min(sides)
        return {"kind": kind, "width": sides[0], "height": sides[1], "radius": radius}
    if kind == "polygon":
        outlines = (
            [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.0), (0.0, 0.0), (0.0, 0.5), (-0.5, 0.5)],
            [(-0.5, -0.4), (0.5, -0.3), (0.1, 0.5)],
            [(0.0, -0.5), (0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)],
        )
        return {"kind": kind, "points": [list(p) for p in outlines[rng.integers(3)]]}
    return {"kind": kind}


def _spectrum(rng, lens):
    """Wavelengths (nm), (channels, n) response of a perfect diffuser, and the channel letters of four photosites."""
    if rng.random() < 0.6:
        return [REFERENCE_NM if rng.random() < 0.5 else float(rng.uniform(380.0, 900.0))], [[1.0]], [0, 0, 0, 0]
    count = int(rng.choice([2, 3, 5, 12, 31], p=[0.3, 0.25, 0.2, 0.15, 0.1]))
    if lens["kind"] == "wavefront":
        count = min(count, WAVELENGTHS)
    width = float(rng.choice([2.0, 30.0, 300.0]))
    nm = (
        np.sort(550.0 + width * (rng.random(count) - 0.5))
        if rng.random() < 0.5
        else 550.0 + width * np.linspace(-0.5, 0.5, count)
    )
    channels = int(rng.choice([1, 3, 4]))
    response = rng.random((channels, count)) ** 2 * 10.0 ** rng.uniform(-1.0, 4.0)
    layout = {1: [0, 0, 0, 0], 3: [0, 1, 1, 2], 4: [0, 1, 2, 3]}[channels]
    return nm.tolist(), response.tolist(), layout


def _surface(rng, spectral):
    if spectral and rng.random() < 0.7:
        nm = [400.0, *np.sort(rng.uniform(500.0, 600.0, 2)).tolist(), 700.0]
        return {"wavelength_nm": nm, "values": rng.random(4).tolist()}
    return float(rng.choice([0.0, 1.0, 0.18, rng.random(), rng.random(), 0.02], p=[0.2, 0.25, 0.15, 0.2, 0.15, 0.05]))


def _scene(rng, rows, cols, spectral, far):
    kinds = ["polygons", "aligned", "diamonds", "discs", "slivers", "touching", "crowd", "elsewhere", "giants"]
    weights = np.array([0.2, 0.25, 0.07, 0.12, 0.08, 0.1, 0.05, 0.05, 0.08 if far else 0.0])
    size = max(rows, cols, 4)
    shapes = []
    for kind in rng.choice(kinds, 1 + int(rng.random() < 0.25), p=weights / weights.sum()):
        shapes += _SCENES[str(kind)](rng, size)
    _painted(rng, shapes, spectral)
    if rng.random() < 0.1 and len(shapes) > 1:
        shapes[-1]["reflectance"] = shapes[0]["reflectance"]  # neighbours of one colour
    return shapes


def _painted(rng, shapes, spectral):
    for shape in shapes:
        shape["reflectance"] = _surface(rng, spectral)


def _with_curves(rng, shapes, size, spectral):
    """One to three shapes of arcs, or with holes, over the others, under them or in their place."""
    curved = _curves(rng, size, spectral)
    if (place := rng.random()) < 0.4:
        return curved
    return curved + shapes if place < 0.6 else shapes + curved


def _plain(rng, size):
    """A curved shape, or some polygons, not painted yet."""
    return [_CURVED[rng.integers(len(_CURVED))](rng, size)] if rng.random() < 0.6 else _polygons(rng, size)


def _curves(rng, size, spectral):
    curved = [_CURVED[rng.integers(len(_CURVED))](rng, size) for _ in range(rng.integers(1, 4))]
    _painted(rng, curved, spectral)
    return curved


OUTLINES = (
    [(-1, -1), (1, -1), (1, 1), (-1, 1)],
    [(-1, -0.7), (1.2, -0.5), (0.1, 0.9)],
    [(-1, -0.8), (1, 0), (-1, 0.8), (-0.3, 0)],
    [(-1, -0.5), (0, -0.2), (1, -0.6), (0.6, 0.1), (0.9, 0.7), (0.0, 0.4), (-0.8, 0.8)],
)


def _placed(rng, outline, size, spread=0.6):
    angle = math.radians(_angle(rng))
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    points = np.array(outline, float) * size @ turn + rng.uniform(-spread, spread, 2) * size
    return {"kind": "polygon", "points": points.tolist()}


def _polygons(rng, size):
    return [
        _placed(rng, OUTLINES[rng.integers(len(OUTLINES))], size * 10.0 ** rng.uniform(-1.5, 0.2), 1.0)
        for _ in range(rng.integers(1, 6))
    ]


def _aligned(rng, size):
    """Axis-parallel rectangles whose sides lie on centres, borders or quarters of photosites; they share sides."""
    step = float(rng.choice([0.5, 0.5, 1.0, 0.25]))
    shapes = []
    for _ in range(rng.integers(1, 5)):
        low = np.round(rng.uniform(-0.7, 0.5, 2) * size / step) * step
        extent = np.maximum(np.round(10.0 ** rng.uniform(-1.0, 0.0, 2) * size / step), 1.0) * step
        x, y = low
        w, h = extent
        if rng.random() < 0.5:
            shapes.append(_polygon([(x, y), (x + w, y), (x + w, y + h), (x, y + h)]))
        else:
            shapes.append(_rectangle(w, h, (x + 0.5 * w, y + 0.5 * h), float(rng.choice([0.0, 0.0, 90.0]))))
    return shapes


def _diamonds(rng, size):
    shapes = []
    for _ in range(rng.integers(1, 4)):
        x, y = np.round(2.0 * rng.uniform(-0.5, 0.5, 2) * size) / 2.0
        r = max(round(2.0 * size * 10.0 ** rng.uniform(-1.0, 0.0)), 1) / 2.0
        shapes.append(_polygon([(x + a * r, y + b * r) for a, b in ((-1, 0), (0, -1), (1, 0), (0, 1))]))
    return shapes


def _discs(rng, size):
    shapes = []
    for _ in range(rng.integers(1, 4)):
        radius = size * 10.0 ** rng.uniform(-1.3, 0.8)
        centre = rng.uniform(-0.5, 0.5, 2) * size
        if radius > size:
            # A large one's rim passes through the frame.
            angle = rng.uniform(0.0, 2.0 * math.pi)
            centre = centre + radius * np.array([math.cos(angle), math.sin(angle)])
        elif rng.random() < 0.3:
            radius, centre = max(round(radius), 1), np.round(centre)
        shapes.append({"kind": "disc", "radius": float(radius), "centre": [float(v) for v in centre]})
    if rng.random() < 0.4:
        shapes.insert(int(rng.integers(0, len(shapes) + 1)), _placed(rng, OUTLINES[0], 0.4 * size))
    return shapes


def _slivers(rng, size):
    shapes = []
    for _ in range(rng.integers(1, 3)):
        width = 10.0 ** rng.uniform(-6.0, -0.5)
        length, centre = size * rng.uniform(0.2, 2.0), np.round(rng.uniform(-0.5, 0.5, 2) * size)
        shapes.append(_rectangle(length, width, centre, _angle(rng)))
    return shapes


def _touching(rng, size):
    """Fans of triangles about one corner: all share sides exactly."""
    count = int(rng.integers(3, 8))
    angle = (
        np.sort(rng.uniform(0.0, 2.0 * math.pi, count))
        if rng.random() < 0.5
        else 2.0 * math.pi * np.arange(count) / count
    )
    rim = 0.5 * size * rng.uniform(0.3, 1.5) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    middle = np.round(rng.uniform(-0.3, 0.3, 2) * size * 2.0) / 2.0
    shapes = []
    for a, b in zip(rim, np.roll(rim, -1, axis=0), strict=True):
        if abs(a[0] * b[1] - a[1] * b[0]) > 1e-3 and rng.random() < 0.8:
            shapes.append(
                {"kind": "polygon", "points": [middle.tolist(), (middle + a).tolist(), (middle + b).tolist()]}
            )
    return shapes


def _crowd(rng, size):
    step = size / 4.0
    angle = _angle(rng)
    return [
        _rectangle(0.6 * step, 0.6 * step, (x * step, y * step), angle)
        for x in (-1.5, -0.5, 0.5, 1.5)
        for y in (-1.5, -0.5, 0.5, 1.5)
    ]


def _elsewhere(rng, size):
    shape = _placed(rng, OUTLINES[rng.integers(len(OUTLINES))], size * 10.0 ** rng.uniform(-0.5, 0.3))
    angle, away = rng.uniform(0.0, 2.0 * math.pi), size * 10.0 ** rng.uniform(0.3, 1.0)
    move = np.round(away * np.array([math.cos(angle), math.sin(angle)]))
    return [{"kind": "polygon", "points": (np.array(shape["points"]) + move).tolist()}]


def _giants(rng, size):
    """One side of a huge rectangle crosses the frame: a half-plane, or nearly."""
    large = 10.0 ** rng.uniform(2.5, 7.0)
    angle = math.radians(_angle(rng))
    out = np.array([math.cos(angle), math.sin(angle)])
    along = np.array([-out[1], out[0]])
    foot = (np.round(2.0 * rng.uniform(-0.3, 0.3) * size) / 2.0) * out
    reach = large * rng.uniform(0.3, 1.0, 2)
    if rng.random() < 0.3:
        reach[0] = round(0.3 * size)  # one corner within or near the frame
    points = [
        foot - reach[0] * along,
        foot + reach[1] * along,
        foot + reach[1] * along + large * out,
        foot - reach[0] * along + large * out,
    ]
    return [{"kind": "polygon", "points": [p.tolist() for p in points]}]


def _somewhere(rng, size):
    """A place, at times the centre or a corner of a photosite."""
    place = rng.uniform(-0.5, 0.5, 2) * size
    return (np.round(2.0 * place) / 2.0 if rng.random() < 0.4 else place).tolist()


def _extent(rng, size, most=0.3):
    """A length from a thirtieth of the frame, at times in half pitches."""
    length = size * 10.0 ** rng.uniform(-1.5, most)
    return float(max(round(2.0 * length), 1) / 2.0 if rng.random() < 0.4 else length)


def _ellipse(rng, size):
    radius = _extent(rng, size)
    other = radius * float(rng.choice([1.0, 0.5, 10.0 ** rng.uniform(-2.0, 0.0)]))
    return {"kind": "ellipse", "centre": _somewhere(rng, size), "radii": [radius, other], "rotate_deg": _angle(rng)}


def _ring(rng, size):
    radius = _extent(rng, size)
    inner = radius * float(rng.choice([0.5, 0.9, rng.uniform(0.01, 0.999)]))
    return {"kind": "ring", "centre": _somewhere(rng, size), "radius": radius, "inner": inner}


def _sector(rng, size):
    radius = _extent(rng, size)
    return {
        "kind": "sector",
        "centre": _somewhere(rng, size),
        "radius": radius,
        "inner": radius * float(rng.choice([0.0, 0.0, 0.5, rng.uniform(0.0, 0.99)])),
        "from_deg": _angle(rng) + float(rng.choice([0.0, 90.0, -180.0])),
        "turn_deg": float(rng.choice([90.0, 180.0, 270.0, rng.uniform(0.1, 359.9)])),
    }


def _capsule(rng, size):
    a, b = np.array(_somewhere(rng, size)), np.array(_somewhere(rng, size))
    if np.hypot(*(b - a)) < 1e-3:
        b[0] += 0.5 * size
    return {"kind": "capsule", "points": [a.tolist(), b.tolist()], "width": _extent(rng, size, -0.5)}


def _holed(rng, size):
    """A polygon with a hole or two of its own outline, smaller."""
    which = rng.integers(2)
    shape = _placed(rng, OUTLINES[which], _extent(rng, size))
    points = np.array(shape["points"])
    middle = points.mean(axis=0)
    # Two would cross each other or the outline in a narrow one.
    holes = [(0.3, -0.25), (0.3, 0.25)] if which == 0 and rng.random() < 0.4 else [(0.6, 0.0)]
    along = points[1] - points[0]
    shape["holes"] = [(middle + share * (points - middle) + to * along).tolist() for share, to in holes]
    return shape


_CURVED = (_ellipse, _ring, _sector, _capsule, _holed)
_SCENES = {
    "polygons": _polygons,
    "aligned": _aligned,
    "diamonds": _diamonds,
    "discs": _discs,
    "slivers": _slivers,
    "touching": _touching,
    "crowd": _crowd,
    "elsewhere": _elsewhere,
    "giants": _giants,
}
