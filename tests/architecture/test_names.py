"""Names: the public ones are there, and every physical number says its unit."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import camsim
from tests.tables import rows

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "camsim"

# What people's scripts rely on.
PUBLIC = (
    *("Scene", "Polygon", "Rectangle", "Disc", "Grid", "Airy", "FourSpotOlpf", "SquarePhotosite"),
    *("render", "Rendering", "capture", "save", "Camera", "Region", "Light", "Exposure", "Curve", "Frame"),
    *("Adc", "Cfa", "QuantumEfficiency", "reflectance", "CamsimError"),
    *("Prnu", "DarkCurrent", "ShotNoise", "FullWell", "ReadNoise", "Dsnu"),
)

UNITS = (
    *("lp_per_mm", "px", "um", "um2", "um3", "mm", "m", "nm", "per_um", "per_um2", "deg", "rad", "waves", "pitches"),
    *("w_per_m2", "w_per_m2_nm", "cd_per_m2", "lux", "um2_s_nm"),
    *("e", "electrons", "e_per_s", "dn", "dn_per_e", "electrons_per_dn", "ff"),
    *("s", "seconds", "per_s", "c", "k", "iso", "fraction"),
)
UNITLESS = {name for _, names in rows("names.txt", "numbers without a unit") for name in names.split()}
NUMBERS = ("float", "F64", "F32", "Spectrum", "Reflectance", "Transmission", "Filter", "Corners", "Point")
LIMITED = ("Positive", "NonNegative", "Fraction", "Celsius")
NUMBER = re.compile(rf"\b({'|'.join((*NUMBERS, *LIMITED))})\b")
# The rooms of the public stages; in rendering and measure lengths are in pitches and pixels, as their docstrings say.
ROOMS = ("optics", "scene", "sensor", "spectra", "camera")
ROOMS += ("rendering/grid.py", "rendering/render.py", "rendering/running.py")


def has_unit(name):
    return name in UNITLESS or any(name == unit or name.endswith("_" + unit) for unit in UNITS)


def sources():
    for room in ROOMS:
        path = PACKAGE / room
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


def public_numbers():
    """Yield (where, name) of every number in a public class: its fields, and what its public methods take."""
    for path in sources():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for owner in (n for n in tree.body if isinstance(n, ast.ClassDef) and not n.name.startswith("_")):
            where = f"{path.relative_to(ROOT)}:{owner.name}"
            for node in owner.body:
                if isinstance(node, ast.AnnAssign) and is_number(node.annotation):
                    yield where, node.target.id
                if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                    for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
                        if argument.annotation and is_number(argument.annotation):
                            yield f"{where}.{node.name}", argument.arg


def is_number(annotation):
    text = ast.unparse(annotation)
    return NUMBER.search(text) is not None and "Callable" not in text


@pytest.mark.parametrize("name", PUBLIC)
def test_public_names_are_there_and_say_what_they_are(name):
    thing = getattr(camsim, name)
    assert name in camsim.__all__
    assert name in dir(camsim)
    assert inspect.getdoc(thing)
    assert thing.__module__.startswith("camsim.")


def test_the_version_is_a_version():
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", camsim.__version__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="Scenery"):
        _ = camsim.Scenery


def test_every_number_says_its_unit():
    nameless = sorted({f"{where}: {name}" for where, name in public_numbers() if not has_unit(name)})
    assert not nameless, "\n".join(nameless)


def test_the_search_finds_numbers():
    found = {name for _, name in public_numbers()}
    assert {"pitch_um", "f_number", "time_s", "sigma_e", "wavelength_nm", "reflectance", "electrons_per_dn"} <= found
    assert len(found) > 40


def test_no_bare_gain_and_no_width_of_an_olpf():
    """Names that have meant two things elsewhere."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.arg | ast.AnnAssign):
                name = node.arg if isinstance(node, ast.arg) else ast.unparse(node.target)
                assert name not in {"gain", "olpf_width", "width_olpf", "quantum_efficiency_percent"}, path


def test_no_file_names_a_place_on_somebodys_machine():
    """Absolute paths into home, work or temporary folders, wherever people may read them."""
    place = re.compile(r"(?<![\w.~{$])/(?:home|root|work|Users|mnt|tmp)/\w")
    found = []
    for suffix in ("py", "md", "yaml", "yml", "toml", "cff", "jsonl"):
        for path in ROOT.rglob(f"*.{suffix}"):
            relative = path.relative_to(ROOT)
            if relative.parts[0].startswith((".", "out", "dist", "build")):
                continue
            for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                if place.search(line):
                    found.append(f"{relative}:{number}: {line.strip()[:80]}")
    assert not found, "\n".join(found)
