"""A system as camsim's objects, as Python to copy, and as the truth's."""

import functools

import numpy as np

import camsim
from camsim.optics import OpticalSystem
from camsim.rendering import render_channels
from camsim.rendering.render import plan_render
from tests.attack.draw import REFERENCE_NM
from tests.attack.moved import moved
from tests.truth import field_lens, fields, groups, picture, round_lenses, waves
from tests.truth.boundary import BoundaryTruth

FIELD_LENSES = ("field", "field grid")


def scene(system):
    p, shapes = system["pitch_um"], system["shapes"]
    if tilt := system["lens"].get("tilt_waves"):
        # W = 2ax moves the image by 2λN ∂W/∂x.
        shapes = [moved(shape, [-4.0 * a * system["lens"]["blur"] for a in tilt]) for shape in shapes]
    return camsim.Scene(background=_surface(system["background"]), shapes=[_shape(shape, p) for shape in shapes])


def _shape(shape, p):
    if fields.is_field(shape):
        return _field(shape, p)
    if "shapes" in shape:
        return _of_shapes(shape, p)
    item = {"reflectance": _surface(shape["reflectance"])}
    if shape["kind"] == "disc":
        return camsim.Disc(radius_um=shape["radius"] * p, centre_um=_times(shape["centre"], p), **item)
    if shape["kind"] == "ellipse":
        return camsim.Ellipse(
            radius_x_um=shape["radii"][0] * p,
            radius_y_um=shape["radii"][1] * p,
            centre_um=_times(shape["centre"], p),
            rotate_deg=shape["rotate_deg"],
            **item,
        )
    if shape["kind"] in ("ring", "sector"):
        item |= {"radius_um": shape["radius"] * p, "centre_um": _times(shape["centre"], p)}
        item["inner_radius_um"] = shape["inner"] * p
        if shape["kind"] == "ring":
            return camsim.Ring(**item)
        return camsim.Sector(from_deg=shape["from_deg"], turn_deg=shape["turn_deg"], **item)
    if shape["kind"] == "capsule":
        a, b = (_times(point, p) for point in shape["points"])
        return camsim.Line(segments_um=[("move", *a), ("line", *b)], width_um=shape["width"] * p, cap="round", **item)
    if shape["kind"] == "path":
        return camsim.Path(segments_um=_segments(shape["outlines"], p), fill_rule=shape["rule"], **item)
    if shape["kind"] == "rectangle":
        return camsim.Rectangle(
            width_um=shape["width"] * p,
            height_um=shape["height"] * p,
            centre_um=_times(shape["centre"], p),
            rotate_deg=shape["rotate_deg"],
            **item,
        )
    holes = tuple(tuple(_times(point, p) for point in hole) for hole in shape.get("holes", ()))
    return camsim.Polygon(points_um=tuple(_times(point, p) for point in shape["points"]), holes_um=holes, **item)


def _segments(outlines, p):
    words = {1: "line", 2: "quadratic", 3: "cubic"}
    found = []
    for start, *segments in outlines:
        found.append(("move", *_times(start, p)))
        found += [(words[len(points)], *(x for point in points for x in _times(point, p))) for points in segments]
        found.append(("close",))
    return found


def _of_shapes(shape, p):
    """A group or a repeat; what clips is given some reflectance, which plays no part."""
    item = {"shapes": [_shape(each, p) for each in shape["shapes"]]}
    if shape["kind"] == "repeat-on-grid":
        return camsim.RepeatOnGrid(rows=shape["rows"], cols=shape["cols"], step_um=_times(shape["step"], p), **item)
    if shape["kind"] == "repeat-on-ring":
        return camsim.RepeatOnRing(count=shape["count"], centre_um=_times(shape["centre"], p), **item)
    return camsim.Group(
        mirror=shape["mirror"],
        scale=tuple(shape["scale"]),
        turn_deg=shape["turn_deg"],
        move_um=_times(shape["move"], p),
        clip=None if shape["clip"] is None else _shape(shape["clip"] | {"reflectance": 0.0}, p),
        **item,
    )


def _field(shape, p):
    placed = {"centre_um": _times(shape["centre"], p)}
    if shape["kind"] == "picture":
        return camsim.Picture(
            planes=np.array(shape["samples"]),
            spectra=(_surface(shape["reflectance"]),),
            width_um=shape["step"] * len(shape["samples"][0]) * p,
            rotate_deg=shape["rotate_deg"],
            interpolation=shape["interpolation"],
            **placed,
        )
    item = placed | {"low": shape["low"], "high": shape["high"]}
    if shape["kind"] == "radial-gradient":
        return camsim.RadialGradient(radius_um=shape["radius"] * p, **item)
    item |= {name + "_um": shape[name] * p for name in ("width", "height")} | {"rotate_deg": shape["rotate_deg"]}
    if shape["kind"] == "linear-gradient":
        return camsim.LinearGradient(**item)
    return camsim.SineGrating(period_um=shape["period"] * p, **item)


def _times(values, p):
    return tuple(float(v) * p for v in values)


def _surface(value):
    if isinstance(value, dict):
        return camsim.Curve(tuple(value["wavelength_nm"]), tuple(value["values"]), outside="hold")
    return value


def _olpf(olpf, pitch_um):
    """Two crossed plates, or one; one that splits along y is one along x turned by a quarter."""
    x_um, y_um, turn = olpf["split"] * pitch_um, olpf["split_y"] * pitch_um, olpf["rotate_deg"]
    if x_um and y_um:
        return camsim.FourSpotOlpf(split_um=x_um, split_y_um=y_um, rotate_deg=turn)
    return camsim.TwoSpotOlpf(split_um=x_um or y_um, rotate_deg=turn if x_um else turn + 90.0)


def optics(system):
    """Lens, OLPF and photosite, in the order light meets them."""
    p, lens = system["pitch_um"], system["lens"]
    stages = [_lens(lens, p)]
    olpf = system["olpf"]
    if olpf:
        stages.append(_olpf(olpf, p))
    stages.append(_photosite(system["photosite"], p))
    return stages


def _lens(lens, p):
    kind, blur_um = lens["kind"], lens["blur"] * p
    f_number = blur_um / (REFERENCE_NM * 1e-3)
    if kind == "airy":
        return camsim.Airy(f_number=f_number)
    if kind == "annular":
        return camsim.AnnularAiry(f_number=f_number, obstruction=lens["obstruction"])
    if kind == "gaussian":
        return camsim.Gaussian(sigma_um=blur_um)
    if kind == "ellipse":
        return camsim.EllipticalGaussian.from_axes(
            sigma_um=blur_um, sigma_across_um=blur_um / lens["ratio"], rotate_deg=lens["rotate_deg"]
        )
    if kind == "curve":
        frequency = tuple(f / blur_um for f in lens["frequency"])
        return camsim.RadialOtf(freq_per_um=frequency, values=tuple(lens["values"]))
    if kind in FIELD_LENSES:
        return _field_lens(lens, p, f_number)
    if kind == "measured":
        return camsim.MeasuredPsf(irradiance=tuple(map(tuple, lens["irradiance"])), spacing_um=0.5 * blur_um)
    across, down = lens.get("tilt_waves", (0.0, 0.0))
    tilt = tuple((j, c) for j, c in ((1, down), (2, across)) if c)
    return camsim.Wavefront(
        f_number=f_number,
        zernike_waves=(*tilt, *((j, c) for j, c in lens["zernike_waves"])),
        reference_nm=REFERENCE_NM,
        defocus_um=_defocus_um(lens, p),
        pupil=camsim.Pupil(**lens["pupil"]),
    )


def _field_lens(lens, p, f_number):
    item = {name: lens[name] for name in ("wavelength_nm", "zernike", "waves")}
    item |= {name: lens[name] for name in ("distortion", "distortion_powers") if name in lens}
    if "illumination" in lens:
        item["relative_illumination"] = lens["illumination"]
    if "lateral" in lens:
        item["lateral_colour_um"] = [_times(row, p) for row in lens["lateral"]]
    for name, key in (("heights", "height_um"), ("x", "x_um"), ("y", "y_um")):
        if name in lens:
            item[key] = _times(lens[name], p)
    return camsim.FieldLens(f_number=f_number, **item)


def _defocus_um(lens, p):
    """The focus shift that is ``defocus_waves`` at the rim: δ/(8N²) of path."""
    f_number = lens["blur"] * p / (REFERENCE_NM * 1e-3)
    return lens["defocus_waves"] * REFERENCE_NM * 1e-3 * 8.0 * f_number**2


def _photosite(photosite, p):
    kind = photosite["kind"]
    if kind == "point":
        return camsim.SquarePhotosite(side_um=0.0)
    if kind == "square":
        return camsim.SquarePhotosite(side_um=photosite["side"] * p)
    if kind == "rectangle":
        return camsim.RectangularPhotosite(width_um=photosite["width"] * p, height_um=photosite["height"] * p)
    if kind == "circle":
        return camsim.CircularPhotosite(diameter_um=photosite["diameter"] * p)
    if kind == "rounded":
        return camsim.RoundedPhotosite(
            width_um=photosite["width"] * p, height_um=photosite["height"] * p, radius_um=photosite["radius"] * p
        )
    return camsim.PolygonPhotosite(points_um=tuple(_times(point, p) for point in photosite["points"]))


def grid(system):
    item = system["grid"]
    return camsim.Grid(
        rows=item["rows"],
        cols=item["cols"],
        pitch_um=system["pitch_um"],
        origin=tuple(item["origin"]),
        frame=None if item["frame"] is None else tuple(item["frame"]),
    )


def channel(system):
    item = system["grid"]
    tile = np.array(system["layout"], np.uint8).reshape(2, 2)
    rows, cols = item["rows"], item["cols"]
    return np.tile(tile, (rows // 2 + 1, cols // 2 + 1))[:rows, :cols].copy()


def choice(system, *, tolerance, method):
    """How camsim would render it: a plan with what it expects to take, one core."""
    return plan_render(*_stages(system), **_light(system), tolerance=tolerance, method=method)


def rendered(system, *, tolerance=None, method=None, every_channel=False):
    """What camsim makes of it."""
    return render_channels(
        *_stages(system),
        **_light(system),
        channel=channel(system),
        tolerance=system["tolerance"] if tolerance is None else tolerance,
        method=system["method"] if method is None else method,
        every_channel=every_channel,
    )


def _stages(system):
    return scene(system), OpticalSystem.of(optics(system)), grid(system)


def _light(system):
    return {"response": np.array(system["response"]), "wavelength_nm": np.array(system["wavelength_nm"])}


def code(system):
    """The system as Python that renders it."""
    return "\n".join(
        [
            "import camsim, numpy as np",
            "from camsim import *",
            "from camsim.optics import OpticalSystem",
            "from camsim.rendering import render_channels",
            f"scene = {scene(system)!r}",
            f"optics = {optics(system)!r}",
            f"grid = {grid(system)!r}",
            f"tile = np.array({system['layout']}, np.uint8).reshape(2, 2)",
            "channel = np.tile(tile, (33, 33))[:grid.rows, :grid.cols]",
            f"r = render_channels(scene, OpticalSystem.of(optics), grid, response=np.array({system['response']}), "
            f"wavelength_nm=np.array({system['wavelength_nm']}), channel=channel, "
            f"tolerance={system['tolerance']!r}, method={system['method']!r})",
        ]
    )


class Truth:
    """What the truth needs of a system, in pitches; the value of photosites by the road asked for."""

    def __init__(self, system):
        self.system = system
        nm, response = np.array(system["wavelength_nm"]), np.array(system["response"])
        drawn = groups.flattened(system["shapes"])
        shapes, owner = fields.parted(drawn)
        # A field is black among the shapes; its light comes apart.
        spectra = [
            _values(s["reflectance"], nm) if k < 0 else np.zeros(nm.size) for s, k in zip(shapes, owner, strict=True)
        ]
        ground = _values(system["background"], nm)
        self.response = response
        self.base = response @ ground
        exposed = sorted({k for k in owner if k >= 0})
        brightest = (response @ np.array([ground, *spectra]).T).max(axis=1)
        self.scale = np.maximum(response.sum(axis=1), brightest)
        self.scale = np.where(self.scale > 0.0, self.scale, 1.0)
        pieces = picture.pieces(shapes)
        of = [*spectra, ground]  # −1: the background
        self.pieces = [p for p in pieces if np.any(of[p.left] != of[p.right])]
        self.difference = np.array([of[p.left] - of[p.right] for p in self.pieces]).reshape(-1, nm.size)
        self._boundaries = {}
        self.lights = []
        for k in exposed:
            cutoff = max(lens.cutoff for lens in self.any_lens)
            ways = (fields.light_of(drawn, pieces, owner, k, cutoff=cutoff, more=more) for more in (9, 7))
            self.lights.append((*ways, _values(drawn[k].get("reflectance", 1.0), nm)))
        item = system["grid"]
        rows, cols = item["frame"] or (item["rows"], item["cols"])
        self.x = item["origin"][1] + 0.5 - 0.5 * cols + np.arange(item["cols"])
        self.y = item["origin"][0] + 0.5 - 0.5 * rows + np.arange(item["rows"])

    @functools.cached_property
    def round(self):
        """The lens at every wavelength, None where it is not round."""
        lens, found = self.system["lens"], []
        for nm in self.system["wavelength_nm"]:
            blur = lens["blur"] * nm / REFERENCE_NM
            if lens["kind"] == "airy":
                found.append(round_lenses.Airy(blur))
            elif lens["kind"] == "annular":
                found.append(round_lenses.Airy(blur, lens["obstruction"]))
            elif lens["kind"] == "gaussian":
                found.append(round_lenses.Gauss(lens["blur"]))
            elif lens["kind"] == "curve":
                found += found[:1] or [
                    round_lenses.Curve([f / lens["blur"] for f in lens["frequency"]], lens["values"])
                ]
            else:
                return None
        return found

    @functools.cached_property
    def any_lens(self):
        lens = self.system["lens"]
        if self.round is not None:
            each = {one: waves.Round(one) for one in self.round}
            return [each[one] for one in self.round]
        if lens["kind"] == "ellipse":
            a = np.radians(lens["rotate_deg"])
            along, across = np.array([np.cos(a), np.sin(a)]), np.array([-np.sin(a), np.cos(a)])
            short = lens["blur"] / lens["ratio"]
            covariance = lens["blur"] ** 2 * np.outer(along, along) + short**2 * np.outer(across, across)
            return [waves.Ellipse(covariance)] * len(self.system["wavelength_nm"])
        if lens["kind"] == "measured":
            return [waves.Samples(lens["irradiance"], 0.5 * lens["blur"])] * len(self.system["wavelength_nm"])
        item = {
            "pupil": lens["pupil"],
            "zernike_waves": lens["zernike_waves"],
            "reference_nm": REFERENCE_NM,
            "f_number": 1.0,
            # δ/(8N²) of path is what counts: so many waves at the rim.
            "defocus_um": lens["defocus_waves"] * REFERENCE_NM * 8e-3,
            "blur": lens["blur"] / REFERENCE_NM,
        }
        return [waves.Opening(item, nm) for nm in self.system["wavelength_nm"]]

    def everywhere(self, channel=0):
        """Light (rows, cols) of every photosite as if it were in one channel, relative to full scale, and its error."""
        values, error = self.waves(channel).values(self.x, self.y)
        return self.base[channel] / self.scale[channel] + values, error

    def at(self, row, col, channel=0, *, target):
        """Light of one photosite, relative to full scale, and its error."""
        value, error = self.these([row], [col], channel, target=target)
        return float(value[0]), float(error[0])

    def these(self, rows, cols, channel=0, *, target):
        """Light of some photosites, relative to full scale, and the error of each."""
        points = np.stack([self.x[cols], self.y[rows]], axis=1)
        value, error = self.boundary(channel, target).values(points)
        return self.base[channel] / self.scale[channel] + value, error

    def boundary(self, channel, target):
        """Truth of single photosites in one channel, relative to its scale."""
        if (channel, target) not in self._boundaries:
            jumps = self.difference * self.response[channel] / self.scale[channel]
            self._boundaries[channel, target] = BoundaryTruth(
                self.pieces, self.round, jumps, self.system["photosite"], self.system["olpf"], target=target,
                lights=self._lights(channel),
            )  # fmt: skip
        return self._boundaries[channel, target]

    def placed(self, channel, digits=waves.DIGITS):
        """Truth of single photosites behind a lens that changes over the frame, relative to one channel's scale."""
        jumps = self.difference * self.response[channel] / self.scale[channel]
        return field_lens.PlacedTruth(
            self.system["lens"], self.pieces, jumps, self.system["photosite"], self.system["olpf"],
            nm=self.system["wavelength_nm"], reference_nm=REFERENCE_NM, digits=digits,
        )  # fmt: skip

    def waves(self, channel, digits=waves.DIGITS):
        """Truth of all photosites in one channel, relative to its scale."""
        jumps = self.difference * self.response[channel] / self.scale[channel]
        return waves.WaveTruth(
            self.pieces, self.any_lens, jumps, self.system["photosite"], self.system["olpf"],
            lights=self._lights(channel), digits=digits,
        )  # fmt: skip

    def _lights(self, channel):
        weights = self.response[channel] / self.scale[channel]
        return [(*ways, item * weights) for *ways, item in self.lights if len(ways[0][1])]


def _values(surface, nm):
    if isinstance(surface, dict):
        return np.interp(nm, surface["wavelength_nm"], surface["values"])
    return np.full(nm.shape, float(surface))
