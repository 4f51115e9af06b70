"""study/1: many captures of one scene or several, with parameters that vary."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from camsim.config.schema.base import Name, Table, by_form
from camsim.core.annotations import Called
from camsim.core.typed import Fraction

MOST = 1_000_000

Range: TypeAlias = Annotated[
    tuple[float, float, Annotated[int, Field(ge=1, le=MOST)]], Called("[first, last, how many]")
]
Pair: TypeAlias = Annotated[tuple[float, float], Called("a pair of numbers")]
Whole: TypeAlias = Annotated[int, Field(ge=-(2**63), le=2**63 - 1)]
Wholes: TypeAlias = Annotated[tuple[Whole, Whole], Called("a pair of whole numbers")]

LIGHT_FILE = "light.file"
"""The key by which ``light`` varies."""

SPREAD = ("linear", "log", "glob")
DRAWN = ("uniform", "log_uniform", "normal", "integers", "choice")


class Values(Table):
    """Values of a key by a rule: spread evenly, the files of a folder, or drawn at random."""

    linear: Range | None = Field(default=None, description="[first, last, how many], evenly spaced")
    log: Range | None = Field(default=None, description="[first, last, how many], evenly spaced in their logarithm")
    glob: Name | None = Field(
        default=None, description="files that match, such as photos/*.jpg, from this file's folder, by their names"
    )
    uniform: Pair | None = Field(default=None, description="[low, high]: drawn anywhere between")
    log_uniform: Pair | None = Field(default=None, description="[low, high]: drawn evenly in their logarithm")
    normal: Pair | None = Field(default=None, description="[mean, standard deviation]: drawn normally")
    integers: Wholes | None = Field(default=None, description="[low, high]: drawn from whole numbers, both included")
    choice: list[Any] | None = Field(default=None, min_length=1, description="drawn from a list")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield faults unless one rule is given, with valid numbers."""
        rules = [key for key in (*SPREAD, *DRAWN) if table.get(key) is not None]
        if not rules:
            yield "linear", f"missing; give a list of values, or one of {', '.join((*SPREAD, *DRAWN))}"
        for key in rules[1:]:
            yield key, f"given together with '{rules[0]}'; a key varies by one rule, leave one of the two out"
        for key in ("log", "log_uniform"):
            ends = table.get(key)
            if isinstance(ends, list | tuple) and any(isinstance(v, int | float) and v <= 0.0 for v in ends[:2]):
                yield key, "has no logarithm; give ends above 0"
        for key in ("uniform", "log_uniform", "integers", "normal"):
            pair = table.get(key)
            if not isinstance(pair, list | tuple) or [type(v) in (int, float) for v in pair] != [True, True]:
                continue
            if key == "normal" and pair[1] < 0.0:
                yield key, f"scatters by {pair[1]:g}; a standard deviation is 0 or more"
            elif key != "normal" and pair[0] > pair[1]:
                yield key, f"begins above its end; give [{pair[1]:g}, {pair[0]:g}]"
            elif key == "uniform" and not math.isfinite(pair[1] - pair[0]):
                yield key, f"is wider than numbers are; give ends nearer than {pair[0]:g} and {pair[1]:g}"


Varied: TypeAlias = Annotated[
    Annotated[list[Any], Field(min_length=1), Tag("list")] | Annotated[Values, Tag("table")], by_form
]
Names: TypeAlias = Annotated[
    Annotated[Name, Tag("word")] | Annotated[list[Name], Field(min_length=1), Tag("list")], by_form
]
Key: TypeAlias = Annotated[str, Field(min_length=1, description="as of --set: exposure.iso, sensor.olpf.split_um …")]


class Varying(Table):
    """Captures of a base scene, with keys that vary."""

    name: Name | None = Field(default=None, description="what reports call it; the file's name when left out")
    scene: Names | None = Field(
        default=None, description="a scene (camsim list scenes, or a file in this study's folder), or a list"
    )
    light: Name | None = Field(
        default=None,
        description="instead, or for a scene with lens: none: files of light on the sensor that match, such as "
        "renders/*.exr, from this file's folder; each is a capture",
    )
    sensor: Name | None = Field(
        default=None, description="a sensor instead of the scenes' own; a file lies in this study's folder"
    )
    set: dict[Key, Any] = Field(default={}, description="keys that are the same in every capture, as of --set")
    vary: dict[Key, Varied] = Field(default={}, description="keys with their values: a list, or a rule")
    combine: Literal["product", "zip", "sequential"] = Field(
        default="product",
        description="every value with every other; the first with the first and so on; or one key after another",
    )
    draws: int = Field(default=1, ge=1, le=MOST, description="how often what is drawn is drawn for each combination")
    seed: int = Field(
        default=0, ge=0, le=2**63 - 1, description="of what is drawn and of the noise; give each data set its own"
    )

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield faults: draws without random values, and keys given twice."""
        vary, same = table.get("vary"), table.get("set")
        vary, same = (part if isinstance(part, Mapping) else {} for part in (vary, same))
        if table.get("scene") is None and table.get("light") is None:
            yield "scene", "missing; name one, or a list, or files of light on the sensor by light"
        if table.get("light") is not None:
            where = next((word for word, keys in (("set", same), ("vary", vary)) if LIGHT_FILE in keys), None)
            if where is not None:
                yield "light", f"given here, and {LIGHT_FILE} in {where}; leave it out in one of the two"
            if table.get("scene") is None and table.get("sensor") is None and "sensor" not in (*same, *vary):
                yield "sensor", "missing; without a scene the sensor that the light falls on is named here"
        for part, keys in (("set", same), ("vary", vary)):
            if spaced := next((key for key in keys if key != key.strip()), None):
                yield part, f"{spaced!r} has spaces beside it; leave them out"
        for key in vary:
            if key in same:
                yield "set", f"{key} is set and varied; leave it out in one of the two"
        if table.get("sensor") is not None and "sensor" in (*same, *vary):
            where = "set" if "sensor" in same else "vary"
            yield "sensor", f"given here and in {where}, which would have no effect; leave it out in one of the two"
        drawn = {key for key, values in vary.items() if isinstance(values, Mapping) and set(DRAWN) & set(values)}
        # One after another, those that are listed never meet.
        alone = set(vary) - drawn if table.get("combine") == "sequential" else set[Any]()
        together = [*same, *vary]
        for place, key in enumerate(together):
            before = (one for one in together[:place] if not {one, key} <= alone)
            lost = next((one for one in map(str, before) if one.startswith(f"{key}.")), None)
            if lost is not None:
                where = "set" if lost in same else "vary"
                yield where, f"{lost} is lost, as {key} comes after it and replaces all of it; say {lost} in there"
        if isinstance(table.get("draws"), int) and table["draws"] > 1 and not drawn:
            yield "draws", f"nothing in vary is drawn; give a key one of {', '.join(DRAWN)}"


class StudyFile(Varying):
    """A study: a base scene, keys that vary, and what is stored of every capture."""

    camsim: Literal["study/1"] = Field(description="format of this file")
    frames: int = Field(default=1, ge=1, le=MOST, description="exposures of each, with fresh temporal noise")
    files: Names = Field(
        default="{index:05d}.dng",
        description="of each capture, FILE[:PRODUCT], with {index}, {frame}, {scene} and varied keys as {exposure_iso}",
    )
    measure: list[Literal["mtf", "moire", "noise", "signal"]] = Field(
        default=[],
        description="columns to measure: mtf of slanted edges, moire of a zone plate, noise (and SNR), signal",
    )


class Crops(Table):
    """Windows of every capture, at places that are drawn."""

    rows: int = Field(ge=1, description="photosites from top to bottom")
    cols: int = Field(ge=1, description="photosites from left to right")
    each: int = Field(default=1, ge=1, le=MOST, description="of every capture")


class Splits(Table):
    """Shares of the scenes that go to training, validation and test."""

    train: Fraction = Field(default=0.8, description="share of the different scenes")
    val: Fraction = Field(default=0.1, description="likewise")
    test: Fraction = Field(default=0.1, description="likewise")

    @classmethod
    def contradictions(cls, table: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
        """Yield a fault unless the shares add up to 1."""
        shares = [table.get(name, cls.model_fields[name].default) for name in ("train", "val", "test")]
        if all(isinstance(share, int | float) for share in shares) and abs(sum(shares) - 1.0) > 1e-9:
            yield "train", f"train, val and test add up to {sum(shares):g}; they are shares of 1"


class DatasetFile(Varying):
    """A data set: crops of many captures, noisy with their truth, in shards."""

    camsim: Literal["dataset/1"] = Field(description="format of this file")
    crops: Crops = Field(description="windows of every capture, which may overlap")
    splits: Splits = Field(default=Splits.model_construct(), description="by scene: no scene is in two")
    hold: list[Literal["noisy", "clean", "truth"]] = Field(
        default=["noisy", "clean", "truth"],
        min_length=1,
        description="of each sample: codes with noise, mean electrons of the mosaic, of every channel",
    )
    shards: Literal["tar", "npy", "files"] = Field(
        default="tar",
        description="tar: as webdataset reads them; npy: one array for each shard and part; files: a folder each",
    )
    samples_per_shard: int = Field(
        default=500, ge=1, le=MOST, description="of one split, whose shards are numbered from 0 on"
    )
    licence: Name | None = Field(default=None, description="of the data set, for its card; not stated when left out")
    sources: list[Name] = Field(
        default=[],
        description="whose its pictures and custom spectra are, and their licences, a sentence each, for its card",
    )
    description: str = Field(default="", description="a sentence for its card")
