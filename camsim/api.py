"""Names and YAML in, a Frame out: config → camera → expose."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, TypeVar

from camsim.camera.body import CustomLens
from camsim.camera.camera import Camera
from camsim.camera.capture import Capture, Progress
from camsim.camera.frame import Frame, Products, check_products
from camsim.config import build, build_sensor, coverage, csv_curves, library, overrides, schema, yaml_source
from camsim.config.build_sensor import SensorDocument
from camsim.config.lengths import SceneDocument
from camsim.config.lens_files import read_lens_file
from camsim.config.overrides import Override
from camsim.config.sensor_search import SensorSearch
from camsim.config.tree import MOST_FAULTS
from camsim.config.validated import Validated
from camsim.core import memory
from camsim.core.annotations import Before, Called
from camsim.core.calls import in_words
from camsim.core.typed import Seed, Whole, check, text_of_path
from camsim.errors import CamsimError, ConfigError, Fault, InvalidValueError
from camsim.optics import FieldLens, Lens
from camsim.optics.no_lens import NO_LENS

if TYPE_CHECKING:
    from camsim.camera.shot import Shot

PathOrName = str | os.PathLike[str]
Exposed: TypeAlias = "Capture | Shot"
"""A validated exposure: a camera with a scene, or a sensor with given light."""
T = TypeVar("T")
M = TypeVar("M", schema.SceneFile, schema.SensorFile, schema.ShotFile)


def _listed(given: Any) -> Any:
    """Return the items of an iterable; texts and tables are not split."""
    return tuple(given) if isinstance(given, Iterable) and not isinstance(given, str | bytes | Mapping) else given


def _folders(given: Any) -> Any:
    """Return folders as a sequence; a single one may be given alone."""
    return (given,) if isinstance(given, str | os.PathLike) else _listed(given)


_PATH = Annotated[str, Before(text_of_path), Called("a path or a name")]
_FOLDERS = Annotated[tuple[_PATH, ...], Before(_folders), Called("a list of folders")]
_CHANGES = Annotated[tuple[str, ...], Before(_listed), Called("a list of changes, such as ['exposure.iso=800']")]


@in_words
def capture(
    scene: PathOrName,
    *,
    sensor: PathOrName | None = None,
    overrides: Iterable[str] = (),
    seed: Whole | None = None,
    products: Products = ("mosaic",),
    sensors: Iterable[PathOrName] = (),
    progress: Progress | None = None,
) -> Frame:
    """Take the picture that a scene file describes.

    scene      path of a scene file, or the name of a shipped one
    sensor     instead of the scene's own
    overrides  such as "exposure.iso=800" or "sensor.olpf=null", as ``camsim capture --set``
    seed       of the noise, instead of the scene's
    products   what the frame holds: "mosaic", "electrons", "truth", "preview"
    sensors    folders in which sensors are looked for by name, before CAMSIM_PATH, the scene's folder and the shipped
    progress   called with (stage, fraction done)

    Raises ConfigError listing every fault of the files and the overrides.

    >>> import camsim
    >>> frame = camsim.capture("flat-field", overrides=["region={rows: 2, cols: 2}", "render.tolerance=1e-2"])
    >>> frame
    Frame(2 × 2 photosites of D40-like, 4.88 µm, RG/GB, 12 bits, 0.01 s, ISO 200, seed 1)
    """
    ready = load_any(scene, sensor=sensor, overrides=overrides, seed=seed, products=products, sensors=sensors)
    return ready.frame(products=products, progress=progress)


@in_words
def load(
    scene: PathOrName,
    *,
    sensor: PathOrName | None = None,
    overrides: Iterable[str] = (),
    seed: Whole | None = None,
    products: Products = ("mosaic",),
    sensors: Iterable[PathOrName] = (),
    held: bool = True,
) -> Capture:
    """Read and validate everything that a capture needs, without taking the picture; see ``capture``.

    held : False if codes are streamed to files (``Capture.rows``)

    A file with ``lens: none`` is refused: it has no scene (``load_any``).

    >>> ready = load("flat-field", overrides=["exposure.iso=800"])
    >>> ready.exposure.iso, ready.tolerance
    (800.0, 1e-06)
    """
    ready = load_any(
        scene, sensor=sensor, overrides=overrides, seed=seed, products=products, sensors=sensors, held=held
    )
    if not isinstance(ready, Capture):
        message = "none, and this is of a scene that a lens shows; camsim capture, sweep and dataset take light alone"
        raise ConfigError([Fault(os.fspath(scene), 0, 0, "lens", message)])
    return ready


@in_words
def load_any(
    scene: PathOrName,
    *,
    sensor: PathOrName | None = None,
    overrides: Iterable[str] = (),
    seed: Whole | None = None,
    products: Products = ("mosaic",),
    sensors: Iterable[PathOrName] = (),
    held: bool = True,
) -> Exposed:
    """Read and validate a capture as ``load`` does, or the given light of a file with ``lens: none``."""
    changes, faults = _parsed(overrides)
    seed = _collected(faults, lambda: _seed(seed))
    path = check(scene, _PATH, "scene")
    check_products(products)
    located = _collected(faults, lambda: library.locate("scene", path))
    validated = located and _collected(faults, lambda: _read_scene(located, changes))
    if not located or not validated:
        raise ConfigError(_in_order(faults))
    search = _collected(faults, lambda: _search(sensors, validated.document.folder))
    body = None if search is None else _collected(faults, lambda: _sensor_of(validated, sensor, changes, search))
    ready: Exposed | None
    if validated.model_type is schema.ShotFile:
        ready = _shot(validated, body, seed)
    else:
        ready = _capture(validated, body, Path(located.path).stem, seed, products, held=held)
    faults += [*validated.faults, *(body.faults if body else ())]
    if faults or ready is None:
        raise ConfigError(_in_order(faults))
    return ready


@in_words
def read_lens(lens: PathOrName) -> FieldLens:
    """Read a lens file: a path, or a name from ``camsim list lenses``.

    >>> read_lens("double-gauss").f_number
    5.0
    """
    return read_lens_file(library.locate("lens", check(lens, _PATH, "lens")))


def load_camera(
    sensor: PathOrName, *, lens: Lens, overrides: Iterable[str] = (), sensors: Iterable[PathOrName] = ()
) -> Camera:
    """Return a camera of a sensor file (a path, or a name from ``camsim list sensors``) and a lens.

    overrides  of the sensor, such as "sensor.olpf=null": without a scene, only sensor keys can be set
    """
    check(lens, CustomLens, "lens")  # checked first: not a fault of the sensor's file
    changes, faults = _parsed(overrides)
    faults += [
        Fault(change.place.file, 0, 0, "", "a sensor without a scene has no such key; its own begin with 'sensor.'")
        for change in changes
        if not change.of_sensor
    ]
    search = _collected(faults, lambda: _search(sensors, Path()))
    path = check(sensor, _PATH, "sensor")
    validated = search and _collected(faults, lambda: _sensor(path, changes, search, asked_by="sensor"))
    camera = validated and build_sensor.camera(validated, lens)
    faults += validated.faults if validated else []
    if faults or not camera:
        raise ConfigError(_in_order(faults))
    return camera


def _capture(
    scene: SceneDocument,
    sensor: SensorDocument | None,
    stem: str,
    seed: int | None,
    products: Products,
    *,
    held: bool,
) -> Capture | None:
    """Build every part, so that all faults are collected; None if there are any."""
    frame = sensor.part(("frame",), schema.SensorFrame) if sensor else None
    mount, light, exposure = build.mount(scene), build.light(scene), build.exposure(scene)
    region = build.region(scene, frame)
    content = build.scene_content(scene, frame)
    camera = build_sensor.camera(sensor, mount.lens if mount else None) if sensor else None
    if mount and camera:
        camera = mount.on(camera)
    if sensor and camera and not scene.faults:
        _refuse_what_does_not_fit(scene, sensor, camera, products, held=held)
        if light is not None:
            coverage.refuse_what_light_lies_beyond(scene, sensor, camera, light)
    model = scene.model
    if not (model and camera and sensor and content and light and exposure) or scene.faults or sensor.faults:
        return None
    parts: dict[str, Any] = {"camera": camera, "scene": content, "light": light, "exposure": exposure, "region": region}
    return scene.build(
        (),
        lambda: Capture(
            **parts,
            scene_name=model.name or stem,
            tolerance=model.render.tolerance,
            method=model.render.method,
            strict=model.render.strict,
            noise=model.noise.enabled,
            seed=model.noise.seed if seed is None else seed,
            frame_number=model.noise.frame_number,
            colour_matrix=model.files.colour_matrix,
            spectral_nm=model.files.spectral_nm,
        ),
        keys={"spectral_nm": ("files", "spectral_nm")},
    )


def _shot(document: Validated[schema.ShotFile], sensor: SensorDocument | None, seed: int | None) -> Shot | None:
    frame = sensor.part(("frame",), schema.SensorFrame) if sensor else None
    camera = build_sensor.camera(sensor, NO_LENS) if sensor else None
    from camsim.config import build_shot  # imported here, as captures of scenes do not need it

    return build_shot.shot(document, camera, frame, seed)


def _refuse_what_does_not_fit(
    scene: SceneDocument, sensor: SensorDocument, camera: Camera, products: Products, *, held: bool
) -> None:
    region = scene.part(("region",), schema.Region)
    rows, cols = (region.rows, region.cols) if region else (camera.rows, camera.cols)
    held = held or camera.needs_whole_window
    needed = memory.needed_bytes(rows, cols, len(camera.cfa.channels), products, held=held)
    if not (message := memory.too_large(rows, cols, needed)):
        return
    if region:
        scene.refuse(("region",), f"{message}; make the region smaller")
    else:
        sensor.refuse(("frame",), f"{message}; capture a region of it")


def _search(folders: Iterable[PathOrName], scene_folder: Path) -> SensorSearch:
    try:
        return SensorSearch.of(check(folders, _FOLDERS, "sensors"), scene_folder)
    except InvalidValueError as error:
        raise ConfigError([Fault(error.key, 0, 0, "", error.message)]) from None


def _sensor_of(
    scene: Validated[Any], sensor: PathOrName | None, changes: Iterable[Override], search: SensorSearch
) -> SensorDocument | None:
    """Read the sensor of a capture: that of the flag, else the scene's."""
    if sensor is not None:
        return _sensor(check(sensor, _PATH, "sensor"), changes, search, asked_by="--sensor")
    name, node = scene.value(("sensor",)), scene.document.find(("sensor",))
    if name is None:
        scene.refuse(("sensor",), "missing; name one (camsim list sensors) or use --sensor")
    if not isinstance(name, str) or not name or node is None:
        return None

    def find() -> library.Located:
        # Paths in overrides are relative to the user's working directory.
        if not node.place.line:
            return search.locate_path_or_name(name)
        return search.locate_in_folder(name)

    located = scene.build(("sensor",), find)
    return None if located is None else _read(located, changes, schema.SensorFile)


def _sensor(name: str, changes: Iterable[Override], search: SensorSearch, *, asked_by: str) -> SensorDocument:
    try:
        located = search.locate_path_or_name(name)
    except ConfigError:
        raise
    except CamsimError as error:
        raise ConfigError([Fault(asked_by, 0, 0, "", str(error))]) from None
    return _read(located, changes, schema.SensorFile)


def _read_scene(located: library.Located, changes: Iterable[Override]) -> Validated[Any]:
    """Read a capture's file; with ``lens: none`` it has a different schema."""
    mine = [change for change in changes if not change.of_sensor]
    document = overrides.apply(yaml_source.read(located.path, located.displayed), mine, schema.SceneFile)
    lens = document.find(("lens",))
    if lens is not None and lens.content == "none":
        return _read(located, changes, schema.ShotFile)
    return Validated.of(csv_curves.read_in(document, schema.SceneFile), schema.SceneFile)


def _read(located: library.Located, changes: Iterable[Override], model: type[M]) -> Validated[M]:
    of_sensor = issubclass(model, schema.SensorFile)
    document = yaml_source.read(located.path, located.displayed)
    mine = [change for change in changes if change.of_sensor == of_sensor]
    return Validated.of(csv_curves.read_in(overrides.apply(document, mine, model), model), model)


def _parsed(texts: Iterable[str]) -> tuple[list[Override], list[Fault]]:
    return overrides.parse(check(texts, _CHANGES, "overrides"))


def _seed(seed: Whole | None) -> int | None:
    try:
        return None if seed is None else int(check(seed, Seed, "--seed"))
    except InvalidValueError as error:
        raise ConfigError([Fault(error.key, 0, 0, "", error.message)]) from None


def _collected(faults: list[Fault], make: Callable[[], T]) -> T | None:
    """Return the result of ``make``; its faults are added to ``faults``."""
    try:
        return make()
    except ConfigError as error:
        faults.extend(error.faults)
        return None


def _in_order(faults: list[Fault]) -> list[Fault]:
    """Sort faults by place within files, files in reading order. Note where more may follow."""
    files = list(dict.fromkeys(fault.file for fault in faults))
    there = [sum(fault.file == file for fault in faults) for file in files]
    more = [
        Fault(file, 0, 0, "", f"more than {MOST_FAULTS - 1} faults; mend these first, there may be more")
        for file, count in zip(files, there, strict=True)
        if count >= MOST_FAULTS
    ]
    return sorted(faults, key=lambda fault: (files.index(fault.file), fault.line, fault.column)) + more
