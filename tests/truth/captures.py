"""What a scene file and a sensor file ask for, by first principles: electrons, truth and codes of every photosite.

Both are taken as the plain tables that they are; nothing of camsim reads them. Scenes are rectangles along the axes,
one over the other: a grid of cells of one surface each. Behind Gaussians a cell's image is a product of error functions
averaged over the photosite; behind a perfect lens, stripes alone, ∫ M(f)·sinc(wf)·sin(2πfx)/(πf) df at each wavelength.
Wavelengths are Gauss–Legendre nodes between all points of all curves.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import colour
import numpy as np
import scipy.constants
from scipy.special import ndtr

from tests.truth.electrons import whole_table

NODES, PANEL_NM = 8, 8.0
FREQUENCIES = 24  # nodes for each cycle of a stripe's farthest edge, and as many at the least
LINE_SIGMAS = 6.0
LUMENS_PER_W = 683.002  # of V(λ) in air, straight between its nanometres (CIE S 010)
SIGMAS_PER_WIDTH = 1.0 / math.sqrt(8.0 * math.log(2.0))


@dataclass(frozen=True, eq=False)
class Truth:
    """Electrons (rows, cols) and (rows, cols, channels), codes before they are rounded, and what white gives each.

    letters : of the truth's channels
    """

    mean_electrons: np.ndarray
    truth: np.ndarray
    code: np.ndarray
    diffuser: np.ndarray
    letters: list


def curve(given, nm, outside="hold"):
    """A fraction, by its table or the one number."""
    if not isinstance(given, dict):
        return np.full(nm.shape, float(given))
    held = given.get("outside", outside) == "hold"
    values = given["values"]
    return np.interp(nm, given["wavelength_nm"], values, left=None if held else 0.0, right=None if held else 0.0)


def captured(scene, sensor, eye):
    """The truth of a capture; ``eye``: (nm, values) of the photopic observer."""
    letters, places = filters_of(sensor["cfa"])
    nm, white = diffuser_e(scene, sensor, eye)
    lens, frame, region = scene["lens"], sensor["frame"], scene["region"]
    top, left = region["origin"]
    y, x = (
        (np.arange(first - 1, first + count + 1) + 0.5 - 0.5 * frame[axis]) * frame["pitch_um"]
        for first, count, axis in ((top, region["rows"], "rows"), (left, region["cols"], "cols"))
    )
    planes = np.moveaxis(_planes(scene, sensor, nm, white, x, y), 0, 2)
    if scene["light"].get("at", "scene") == "scene":
        planes = planes * falloff(lens.get("falloff"), np.hypot(*np.meshgrid(x, y)) / 1e3)[..., None]
    kernel = np.array(sensor["charge"].get("crosstalk", [[0, 0, 0], [0, 1, 0], [0, 0, 0]]), float)
    mean, truth = collected(planes, kernel, places, (top, left))
    sees = mixed(white.sum(axis=1), kernel, places)
    rows, cols = np.ogrid[top : top + region["rows"], left : left + region["cols"]]
    each = places[rows % len(places), cols % len(places[0])]
    return Truth(mean, truth, codes(scene, sensor, mean, (top, left)), sees[each], letters)


def filters_of(cfa):
    """Letters, and the index of each place's."""
    if cfa["kind"] == "mono":
        rows = ["Y"]
    elif cfa["kind"] == "letters":
        rows = cfa["pattern"]
    else:
        group = cfa.get("group", 2) if cfa["kind"] == "quad-bayer" else 1
        rows = ["".join(letter * group for letter in row) for row in (cfa["pattern"][:2], cfa["pattern"][2:])]
        rows = [row for row in rows for _ in range(group)]
    letters = sorted(set("".join(rows)))
    return letters, np.array([[letters.index(letter) for letter in row] for row in rows])


def photosite_um(sensor):
    """Width and height of a rectangle that collects light."""
    each, pitch_um = sensor.get("photosite", {"kind": "square"}), sensor["frame"]["pitch_um"]
    if each["kind"] == "rectangular":
        return each["width_um"], each["height_um"]
    side_um = pitch_um * math.sqrt(each.get("fill_factor", 1.0))
    return side_um, side_um


def diffuser_e(scene, sensor, eye):
    """Wavelengths (n,) and electrons (channels, n) of a perfect diffuser, the shares of an integral."""
    letters, _ = filters_of(sensor["cfa"])
    nm, photons = photons_per_um2(scene, sensor, eye)
    efficiency = efficiencies(sensor["quantum_efficiency"], letters, nm)
    return nm, efficiency * photons * math.prod(photosite_um(sensor)) * scene["exposure"]["time_s"]


def photons_per_um2(scene, sensor, eye):
    """Wavelengths and, of a perfect diffuser at each, photons in a second and its share of the integral."""
    light, lens = scene["light"], scene["lens"]
    shape, first, last, points = _shape(light)
    tables = [scene["scene"]["background"]["reflectance"], lens.get("transmission"), lens.get("veiling_glare")]
    tables += [one["reflectance"] for one in scene["scene"]["shapes"]]
    filters = [*lens.get("filters", []), *sensor.get("filters", [])]
    tables += [*filters, *sensor["quantum_efficiency"]["curves"].values()]
    points = [*points, *(nm for table in tables if isinstance(table, dict) for nm in table["wavelength_nm"])]
    nm, weight = _panels([first, *(each for each in points if first < each < last), last])
    power = shape(nm) * weight
    fine_nm, fine = _panels([first, *eye[0][(eye[0] > first) & (eye[0] < last)], *points, last])
    lumens = LUMENS_PER_W * np.sum(shape(fine_nm) * fine * np.interp(fine_nm, *eye, left=0.0, right=0.0))
    if "irradiance_w_per_m2" in light:
        power *= light["irradiance_w_per_m2"] / power.sum()
    elif "illuminance_lux" in light:
        power *= light["illuminance_lux"] / lumens
    else:
        power *= math.pi * light["luminance_cd_per_m2"] / lumens
    if light.get("at", "scene") == "scene":
        working = lens["f_number"] * (1.0 + lens.get("magnification", 0.0))
        power *= curve(lens.get("transmission", 1.0), nm) / (4.0 * working**2)
        power *= opening(lens)
    for each in filters:
        power *= curve(each, nm, outside="zero")
    joules = scipy.constants.h * scipy.constants.c / (nm * 1e-9)
    return nm, power / joules * 1e-12


def opening(lens):
    """The pupil's area over that of the circle of the f-number: a square is round it, an iris within."""
    pupil = lens.get("pupil", {})
    blades = pupil.get("blades", 0)
    areas = {"circular": math.pi, "square": 4.0, "bladed": 0.5 * blades * math.sin(math.tau / max(blades, 1))}
    hole = pupil.get("obstruction", lens.get("obstruction", 0.0))
    return areas[pupil.get("shape", "circular")] / math.pi - hole**2


def _shape(light):
    """Relative power by the wavelength, where it begins and ends, and where it bends."""
    if "line_nm" in light:
        sigma = light["width_nm"] * SIGMAS_PER_WIDTH
        middle, reach = light["line_nm"], LINE_SIGMAS * sigma
        points = np.linspace(middle - reach, middle + reach, 13)[1:-1]
        return lambda nm: np.exp(-0.5 * ((nm - middle) / sigma) ** 2), middle - reach, middle + reach, [*points]
    if "blackbody_k" in light:
        second = scipy.constants.h * scipy.constants.c / scipy.constants.k / light["blackbody_k"]
        return lambda nm: nm**-5.0 / np.expm1(second / (nm * 1e-9)), 300.0, 1100.0, []
    if "illuminant" in light:
        nm, values = whole_table(colour, light["illuminant"])
        table = {"wavelength_nm": nm.tolist(), "values": values}
    else:
        table = light["table"]
    return (
        lambda nm: curve(table, nm, "zero"),
        table["wavelength_nm"][0],
        table["wavelength_nm"][-1],
        table["wavelength_nm"],
    )


def _panels(points):
    """Nodes and weights between points, no panel longer than PANEL_NM."""
    points = np.unique(points)
    parts = [np.linspace(a, b, math.ceil((b - a) / PANEL_NM) + 1)[:-1] for a, b in pairwise(points)]
    ends = np.append(np.concatenate(parts), points[-1])
    node, weight = np.polynomial.legendre.leggauss(NODES)
    middle, half = 0.5 * (ends[1:] + ends[:-1])[:, None], 0.5 * np.diff(ends)[:, None]
    return (middle + half * node).ravel(), (half * weight).ravel()


def efficiencies(stated, letters, nm):
    """Electrons per photon, (channels, n)."""
    volts = scipy.constants.h * scipy.constants.c / scipy.constants.e / (nm * 1e-9)
    per_energy = stated["per"] == "energy"
    rows = [curve(stated["curves"][letter], nm, "zero") * (volts if per_energy else 1.0) for letter in letters]
    if stated["peak"] == "as given":
        return np.array(rows)
    highest = 0.0
    for letter in letters:
        at_nm, values = (np.array(stated["curves"][letter][key], float) for key in ("wavelength_nm", "values"))
        highest = max(highest, (values / at_nm if per_energy else values).max())
    if per_energy:
        highest *= scipy.constants.h * scipy.constants.c / scipy.constants.e * 1e9
    return np.array(rows) * stated["peak"] / highest


def cells(scene, pitch_um):
    """Edges of a grid along x and y, and of each cell the number of the surface on it: 0 is the background's."""
    unit = {"pixel": pitch_um, "um": 1.0, "mm": 1000.0}[scene["unit"]]
    boxes = []
    for shape in scene["shapes"]:
        (x, y), (width, height) = shape["centre"], (shape["width"], shape["height"])
        boxes.append(np.array([[x - width / 2, x + width / 2], [y - height / 2, y + height / 2]]) * unit)
    xs, ys = (np.unique([box[axis] for box in boxes]) if boxes else np.zeros(2) for axis in (0, 1))
    on = np.zeros((len(ys) - 1, len(xs) - 1), int)
    for number, box in enumerate(boxes, start=1):
        across, down = (
            (edges[:-1] >= each[0]) & (edges[1:] <= each[1]) for edges, each in zip((xs, ys), box, strict=True)
        )
        on[np.ix_(down, across)] = number
    return xs, ys, on


def _planes(scene, sensor, nm, white, x, y):
    """Electrons of each channel, (channels, len(y), len(x)), before fall-off and crosstalk."""
    stated, pitch_um, lens = scene["scene"], sensor["frame"]["pitch_um"], scene["lens"]
    surfaces = [stated["background"]["reflectance"], *(shape["reflectance"] for shape in stated["shapes"])]
    surfaces = np.array([curve(surface, nm) for surface in surfaces])
    glare = curve(lens.get("veiling_glare", 0.0), nm)
    xs, ys, on = cells(stated, pitch_um)
    mean = surfaces[0] + _areas(xs, ys, on, sensor["frame"], len(surfaces)) @ (surfaces - surfaces[0])
    planes = ((white * ((1.0 - glare) * surfaces[0] + glare * mean)).sum(axis=1))[:, None, None]
    planes = planes + np.zeros((1, len(y), len(x)))
    if not on.any():
        return planes
    width_um, height_um = photosite_um(sensor)
    spots = spots_um(sensor.get("olpf"), pitch_um)
    for number in range(1, len(surfaces)):
        covered = on == number
        if not covered.any():
            continue
        change = white * (1.0 - glare) * (surfaces[number] - surfaces[0])
        if lens["kind"] == "airy" or lens["kind"] == "annular-airy":
            across = covered.any(axis=0)
            seen = sum(_stripes(lens, nm, xs, across, x - dx, width_um) for dx, _ in spots) / len(spots)
            planes += (change @ seen)[:, None, :]
            continue
        sigma_x, sigma_y = _sigmas(lens)
        each = np.zeros(planes.shape[1:])
        for dx, dy in spots:
            along = np.diff(_step(xs[:, None] - (x - dx), sigma_x, width_um), axis=0)
            down = np.diff(_step(ys[:, None] - (y - dy), sigma_y, height_um), axis=0)
            each += np.einsum("ij,jx,iy->yx", covered.astype(float), along, down) / len(spots)
        planes += change.sum(axis=1)[:, None, None] * each
    return planes


def _areas(xs, ys, on, frame, count):
    """The share of the frame that each surface has."""
    half_x, half_y = (0.5 * frame[axis] * frame["pitch_um"] for axis in ("cols", "rows"))
    wide, high = np.diff(np.clip(xs, -half_x, half_x)), np.diff(np.clip(ys, -half_y, half_y))
    areas = np.bincount(on.ravel(), (high[:, None] * wide).ravel(), minlength=count) / (4.0 * half_x * half_y)
    areas[0] = 0.0
    return areas


def _sigmas(lens):
    """Standard deviations along x and y, µm; elliptical ones lie along the axes."""
    if "mtf50_per_um" in lens:
        sigma = math.sqrt(math.log(2.0) / 2.0) / (math.pi * lens["mtf50_per_um"])
        return sigma, sigma
    first, second = lens["sigma_um"], lens.get("sigma_across_um", lens["sigma_um"])
    return (first, second) if lens.get("rotate_deg", 0) % 180 == 0 else (second, first)


def _step(distance, sigma, width):
    """What an interval of ``width`` sees, on the average, of a blurred step up to ``distance`` from its middle."""

    def rise(t):
        u = t / sigma
        return t * ndtr(u) + sigma * np.exp(-0.5 * u * u) / math.sqrt(2.0 * math.pi)

    return (rise(distance + 0.5 * width) - rise(distance - 0.5 * width)) / width


def _stripes(lens, nm, xs, covered, x, width):
    """What photosites see of stripes without ends behind a perfect lens, (len(nm), len(x))."""
    working = lens["f_number"] * (1.0 + lens.get("magnification", 0.0))
    rises = np.diff(covered.astype(float), prepend=0.0, append=0.0)
    edges = [(at, rise) for at, rise in zip(xs, rises, strict=True) if rise]
    cut = 1.0 / (nm * 1e-3 * working)
    far = max(abs(x[:, None] - [at for at, _ in edges]).max(), width) + width
    hole = lens.get("obstruction", 0.0)
    node, weight = np.polynomial.legendre.leggauss(FREQUENCIES + math.ceil(FREQUENCIES / 4 * far * cut.max()))
    # Where overlaps of rim and hole begin and end the transfer bends.
    ends = np.unique([0.0, hole, 0.5 * (1.0 - hole), 0.5 * (1.0 + hole), 1.0])
    middle, half = 0.5 * (ends[1:] + ends[:-1])[:, None], 0.5 * np.diff(ends)[:, None]
    u, weight = (middle + half * node).ravel(), (half * weight).ravel()
    kept = transfer(u, hole) * weight / (math.pi * u)
    seen = np.zeros((len(nm), len(x)))
    for at, sign in edges:
        phase = 2.0 * math.pi * cut[:, None, None] * (x - at)[:, None] * u
        seen += sign * np.einsum("u,lxu->lx", kept, np.sin(phase) * np.sinc(width * cut[:, None, None] * u))
    return seen


def transfer(u, obstruction):
    """The transfer of a round pupil with a round hole at a share ``u`` of its cut-off: its overlap with itself."""

    def lens_shaped(first, second):
        d = np.clip(2.0 * u, abs(first - second) + 1e-300, first + second)
        one, other = (
            np.arccos(np.clip((d**2 + a**2 - b**2) / (2.0 * d * a), -1.0, 1.0)) if a else np.zeros_like(d)
            for a, b in ((first, second), (second, first))
        )
        return first**2 * (one - np.sin(2 * one) / 2) + second**2 * (other - np.sin(2 * other) / 2)

    whole = lens_shaped(1.0, 1.0) - 2.0 * lens_shaped(1.0, obstruction) + lens_shaped(obstruction, obstruction)
    return whole / (math.pi * (1.0 - obstruction**2))


def spots_um(olpf, pitch_um):
    """Where the filter sends what belongs in the middle."""
    if olpf is None:
        return [(0.0, 0.0)]
    split = olpf.get("split_um", olpf.get("split_pitches", 0.0) * pitch_um)
    turn = math.radians(olpf.get("rotate_deg", 0.0))
    if olpf["kind"] == "two-spot":
        places = [(0.5 * split, 0.0), (-0.5 * split, 0.0)]
    else:
        other = olpf.get("split_y_um", olpf.get("split_y_pitches", split / pitch_um) * pitch_um)
        places = [(0.5 * i * split, 0.5 * j * other) for i in (1, -1) for j in (1, -1)]
    cos, sin = math.cos(turn), math.sin(turn)
    return [(px * cos - py * sin, px * sin + py * cos) for px, py in places]


def falloff(stated, radius_mm):
    """Light relative to the axis's."""
    if stated is None:
        return np.ones_like(radius_mm)
    if stated["kind"] == "cos4":
        return (1.0 + (radius_mm / stated["exit_pupil_mm"]) ** 2) ** -2.0
    return np.interp(radius_mm, stated["radius_mm"], stated["values"])


def collected(planes, kernel, places, origin):
    """Electrons after crosstalk, of each photosite and of every channel; ``planes`` has one more on every side."""
    rows, cols = (size - 2 for size in planes.shape[:2])
    high, wide = places.shape
    at = np.add.outer(np.arange(origin[0] - 1, origin[0] + rows + 1) % high * wide, np.zeros(cols + 2, int))
    each = places.ravel()[at + np.arange(origin[1] - 1, origin[1] + cols + 1) % wide]
    held = np.take_along_axis(planes, each[..., None], axis=2)[..., 0]
    mean = np.zeros((rows, cols))
    truth = np.zeros((rows, cols, planes.shape[2]))
    for i, j in np.ndindex(3, 3):
        # What ends here comes from the photosite on the other side.
        here = np.s_[2 - i : 2 - i + rows, 2 - j : 2 - j + cols]
        mean += kernel[i, j] * held[here]
        sent = np.roll(places, (i - 1, j - 1), axis=(0, 1))
        for channel in range(planes.shape[2]):
            shares = np.bincount(sent[places == channel], minlength=planes.shape[2]) / (places == channel).sum()
            truth[..., channel] += kernel[i, j] * planes[here] @ shares
    index = each[1:-1, 1:-1]
    for channel in range(planes.shape[2]):
        truth[index == channel, channel] = mean[index == channel]
    return mean, truth


def mixed(electrons, kernel, places):
    """What each channel holds of an even surface after crosstalk, by what each collects."""
    out = np.zeros(len(electrons))
    for channel in range(len(electrons)):
        for i, j in np.ndindex(3, 3):
            sent = np.roll(places, (i - 1, j - 1), axis=(0, 1))[places == channel]
            out[channel] += kernel[i, j] * electrons[sent].mean()
    return out


def gain_e(scene, sensor):
    """Electrons per data number at the ISO of the exposure."""
    readout = sensor["readout"]
    return readout["electrons_per_dn"] * readout["base_iso"] / scene["exposure"]["iso"]


def dark_e(scene, sensor):
    """Charge without light, electrons."""
    charge, exposure = sensor["charge"], scene["exposure"]
    at_c = charge.get("dark_current_at_c", 25.0)
    warmer = (exposure.get("temperature_c", at_c) - at_c) / charge.get("dark_current_doubles_every_c", 7.0)
    return charge.get("dark_current_e_per_s", 0.0) * exposure["time_s"] * 2.0**warmer


def codes(scene, sensor, mean, origin):
    """Data numbers of a capture without noise, and so without dark charge, before they are rounded."""
    charge, readout = sensor["charge"], sensor["readout"]
    well = charge.get("full_well_e", math.inf)
    other = readout.get("dual_gain")
    if other and scene["exposure"]["iso"] >= other["from_iso"]:
        well = other.get("full_well_e", well)
    held = np.minimum(mean, well)
    bent = charge.get("nonlinearity")
    if bent and bent["kind"] == "table":
        held = np.interp(held, bent["electrons_in"], bent["electrons_out"])
    elif bent:
        u = held / bent["scale_e"]
        held = held * (1.0 + sum(a * u ** (k + 1) for k, a in enumerate(bent["coefficients"])))
    offsets = np.array(readout.get("black_offsets_dn", [[0]]))
    rows, cols = np.ogrid[origin[0] : origin[0] + len(mean), origin[1] : origin[1] + len(mean[0])]
    black = readout["black_level_dn"] + offsets[rows % len(offsets), cols % len(offsets[0])]
    return np.clip(held / gain_e(scene, sensor) + black, 0, 2 ** readout["bit_depth"] - 1)
