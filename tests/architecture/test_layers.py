"""The house over its syntax trees: who imports whom, and who may know which library."""

import ast
import subprocess
import sys

from bench.imports import DOORS, FLOORS, PACKAGE, SOURCES, circle, doors, graph, module_of, read, upward, within
from tests.tables import rows

LIBRARIES = {library: tuple(known.split()) for library, known in rows("names.txt", "libraries")}
COLOUR_DATA = ("camsim.spectra", "camsim.sensor.colour_matrix", "camsim.measure")
SPEAKS = ("camsim.cli",)


def test_every_module_has_a_layer():
    found = {module_of(path).split(".")[1] for path in SOURCES if module_of(path) != "camsim"}
    assert found <= set(FLOORS)
    assert len(SOURCES) > 50


def test_lower_never_imports_upper():
    assert upward() == []


def test_the_import_graph_has_no_cycle():
    """Not even through a function, a type checker's block, or ``import camsim``."""
    assert len(graph()) > 100
    assert circle() == []


def test_doors_lead_where_the_list_says():
    assert doors() == DOORS


def test_the_house_has_few_rooms():
    """Fourteen folders, and beside the package's own files two."""
    inside = [path for path in PACKAGE.iterdir() if path.name != "__pycache__"]
    assert len([path for path in inside if path.is_dir()]) <= 14
    assert {path.name for path in inside if path.suffix == ".py"} == {
        "__init__.py",
        "__main__.py",
        "api.py",
        "errors.py",
    }


def test_benchmarks_and_tests_are_not_imported():
    """What is beside the package stays beside it: an installed camsim has no bench/ and no tests/."""
    assert not [
        f"{module_of(path)} imports {imported}"
        for path in SOURCES
        for imported in read(path).imports
        if imported.split(".")[0] in ("bench", "tests")
    ]


def test_the_package_itself_loads_nothing():
    """What ``__init__`` gives is in the stub beside it, for type checkers and for whoever asks for a name."""
    names = []
    for node in ast.parse((PACKAGE / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            names.append(node.module)
        elif isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
    assert set(names) == {"lazy_loader"}


def test_libraries_stay_in_their_rooms():
    wrong = [
        f"{module_of(path)} imports {imported}"
        for path in SOURCES
        for imported in read(path).imports
        if not within(module_of(path), LIBRARIES.get(imported.split(".")[0], ("camsim",)))
    ]
    assert not wrong


def test_colour_science_stays_with_spectra_and_colour():
    users = {module_of(path) for path in SOURCES if "camsim.spectra.colour_science" in read(path).imports}
    assert users
    assert all(within(user, COLOUR_DATA) for user in users), users


def test_only_the_command_line_prints_or_exits():
    speech = {"print", "input", "exit", "quit", "sys.exit", "os._exit"}
    wrong = [
        f"{path.relative_to(PACKAGE)}:{line}: {called}"
        for path in SOURCES
        if not within(module_of(path), SPEAKS)
        for line, called, script in read(path).calls
        if called in speech and not script
    ]
    assert not wrong


def test_kernels_know_arrays_only():
    """A compiled function names nothing of a scene, an optical stage or a sensor: arrays in, arrays out."""
    kernels, wrong = 0, []
    for path in SOURCES:
        for name, named in read(path).kernels:
            kernels += 1
            wrong += [f"{module_of(path)}.{name}: {one}" for one in named & read(path).objects]
    assert kernels > 40
    assert not wrong


def test_nothing_is_unfinished():
    words = ("TODO", "FIXME", "XXX", "raise NotImplementedError")
    assert not [path for path in SOURCES if any(word in path.read_text(encoding="utf-8") for word in words)]


def test_what_is_not_needed_is_not_loaded():
    """By the import nothing that takes long; by stages and a flat scene, made in Python, no compiler or geometry."""
    code = """
import camsim, sys
heavy = {'numba', 'shapely', 'pydantic', 'colour', 'scipy', 'yaml', 'typer', 'OpenEXR', 'tifffile', 'PIL'}
assert not (heavy | {'numpy'}) & set(sys.modules), sys.modules
camsim.Airy(f_number=8.0), camsim.FourSpotOlpf(split_um=3.0), camsim.SquarePhotosite(side_um=4.0)
camsim.Scene(background=0.2), camsim.Curve((400.0, 700.0), (0.0, 1.0)), camsim.ReadNoise(3.0)
assert not (heavy - {'scipy'}) & set(sys.modules), sys.modules
"""
    subprocess.run([sys.executable, "-W", "error", "-c", code], check=True, timeout=600)


def test_properties_have_no_lock_in_common():
    """Python 3.11's own has one for all instances; kernels, which stand alone, ask for theirs once a process."""
    each = [path for path in SOURCES if "functools.cached_property" in path.read_text(encoding="utf-8")]
    assert {path.relative_to(PACKAGE).as_posix() for path in each} == {"core/cached.py", "core/kernels/dispatch.py"}
