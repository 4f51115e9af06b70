"""Which key was meant: by spelling, by other people's words for it, or because it lives elsewhere."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from typing import get_args, get_origin

from camsim.config.expect import Expected, expected_of_field
from camsim.config.schema import SceneFile, SensorFile, Table
from camsim.config.tree import KeyPath, dotted

# Words of other programs, of cameras and of data sheets for our keys.
_OTHER_WORDS = {
    "base_iso": "iso native_iso",
    "background": "bg backdrop",
    "bit_depth": "bits bpp adc_bits depth",
    "black_level_dn": "black black_level offset pedestal bias",
    "centre": "center centre_um center_um position pos xy middle",
    "cfa": "bayer pattern color_filter filter mosaic",
    "cols": "columns width width_px nx",
    "csv": "file path table",
    "curves": "curve sensitivities response spectrum",
    "dark_current_e_per_s": "dark dark_current",
    "datetime": "date timestamp when",
    "dsnu_e": "dsnu fpn fixed_pattern",
    "electrons_per_dn": "gain system_gain conversion_gain e_per_dn k",
    "enabled": "on active disabled off",
    "f_number": "aperture fstop f_stop f n fnumber stop",
    "fill_factor": "fill ff",
    "full_well_e": "well capacity saturation full_well_capacity",
    "illuminance_lux": "lux lx illuminance brightness intensity level",
    "illuminant": "spectrum white_point temperature whitepoint",
    "height": "h height_um size_y",
    "iso": "sensitivity gain speed",
    "kind": "type shape form",
    "lens": "optics objective",
    "light": "illumination lighting source",
    "line_nm": "wavelength wavelength_nm laser laser_nm monochromatic",
    "origin": "offset start corner",
    "pattern": "phase order",
    "peak": "max qe maximum",
    "pitch_um": "pixel_size pixel_pitch pixel_size_um pitch_nm pitch_mm",
    "points": "vertices corners coordinates points_um polygon",
    "prnu": "gain_noise",
    "quantum_efficiency": "qe efficiency sensitivity",
    "radius": "r radius_um diameter",
    "read_noise_e": "noise sigma read_noise_dn readnoise",
    "reflectance": "color colour albedo value fill grey gray neutral brightness",
    "region": "roi window crop",
    "rotate_deg": "angle rotation rotate angle_deg tilt rotate_rad",
    "rows": "lines height height_px ny",
    "seed": "random_state random_seed",
    "serial": "serial_number id",
    "shapes": "objects items polygons elements",
    "split_um": "separation shift width_um displacement distance_um",
    "time_s": "shutter shutter_s exposure exposure_time duration integration_time time_ms",
    "tolerance": "accuracy precision error eps",
    "unit": "units",
    "values": "value reflectances y",
    "width": "w width_um size size_x",
    "wavelength_nm": "wavelengths wavelengths_nm lambda nm x",
}


def meant(key: str, allowed: list[str], *, alike: float = 0.6) -> str | None:
    """Return the allowed key that was probably meant, None when nothing is near.

    alike : how much of their letters two words must share, of 1

    >>> meant("read_noise_dn", ["bit_depth", "read_noise_e"]), meant("angle", ["width", "rotate_deg"])
    ('read_noise_e', 'rotate_deg')
    """
    lowered = key.lower().replace("-", "_")
    if lowered in allowed:
        return lowered
    for known in allowed:
        if lowered in _OTHER_WORDS.get(known, "").split():
            return known
    near = difflib.get_close_matches(lowered, allowed, n=1, cutoff=alike)
    return near[0] if near else None


def elsewhere(key: str, root: type[Table], here: KeyPath) -> list[str]:
    """Return the other places of a format where a key of exactly this name belongs, as dotted paths, lists' last."""
    here = tuple(0 if isinstance(part, int) else part for part in here)
    places = dict.fromkeys(path for path in _all_keys(Expected.of(root), ()) if path[-1] == key)
    return [dotted(path) for path in sorted(places, key=lambda path: 0 in path) if path != here]


def place_of(word: str) -> str | None:
    """Return the key that a word means as ``--set`` has it, None when nothing is near.

    >>> place_of("tolerance"), place_of("shutter"), place_of("read-noise"), place_of("out")
    ('render.tolerance', 'exposure.time_s', 'sensor.readout.read_noise_e', None)
    """
    places = dict.fromkeys(_all_keys(Expected.of(SceneFile), ()))
    places |= dict.fromkeys(("sensor", *path) for path in _all_keys(Expected.of(SensorFile), ()))
    found = [path for path in places if 0 not in path]
    # Of a hundred names some are a little like any word.
    name = meant(word, sorted({str(path[-1]) for path in found}), alike=0.8)
    return next((dotted(path) for path in found if path[-1] == name), None)


def _all_keys(expected: Expected, path: KeyPath, above: tuple[type[Table], ...] = ()) -> Iterator[KeyPath]:
    for table in expected.tables():
        for name, field in table.fields().items():
            yield (*path, name)
            inside = expected_of_field(field)
            if not {*inside.holds()} & {*above, table}:  # a group's shapes are told once
                yield from _all_keys(inside, (*path, name), (*above, table))
    for alternative in expected.alternatives():
        if get_origin(alternative.kind) is list:
            yield from _all_keys(Expected.of(get_args(alternative.kind)[0]), (*path, 0), above)
