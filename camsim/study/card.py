"""The card of a data set: a page for people and Croissant metadata for programs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from camsim.config.schema.study import DatasetFile
from camsim.files.atomic import write_whole
from camsim.files.describe import software
from camsim.study.manifest import DONE, PARQUET, Row, sha256_of
from camsim.study.study import Study

_PARTS = {
    "noisy": "codes with noise (data numbers, of a sensor that compands), (rows, cols) uint16, DN",
    "clean": "mean electrons of the mosaic, (rows, cols) float32, e⁻",
    "truth": "mean electrons of every channel at every photosite, (rows, cols, channels) float32, e⁻",
}
_SPECTRA = (
    "Reflectances, illuminants and sensitivities that scenes and sensors name come from colour-science (BSD-3-Clause); "
    "camsim's DATA_LICENSES.md says who measured each."
)
_CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "dct": "http://purl.org/dc/terms/",
    "conformsTo": "dct:conformsTo",
    "recordSet": "cr:recordSet",
    "field": "cr:field",
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "source": "cr:source",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "includes": "cr:includes",
    "extract": "cr:extract",
    "column": "cr:column",
    "references": "cr:references",
    "key": "cr:key",
    "md5": "cr:md5",
    "citeAs": "cr:citeAs",
    "isLiveDataset": "cr:isLiveDataset",
}
_TYPES = {bool: "sc:Boolean", int: "sc:Integer", float: "sc:Float", str: "sc:Text"}


def write_card(folder: Path, study: Study[DatasetFile], rows: Sequence[Row], *, pictures: bool) -> None:
    """Write README.md and croissant.json; ``pictures``: whether any scene shows one."""
    good = [row for row in rows if row["status"] == DONE]
    sources = [_SPECTRA, *study.model.sources]
    if pictures and not study.model.sources:
        sources.append("Whose the pictures are that scenes show is not stated (key sources of the data set's file).")
    write_whole(folder / "README.md", _page(study, good, sources).encode())
    text = json.dumps(_croissant(folder, study, good, sources), indent=1, ensure_ascii=False)
    write_whole(folder / "croissant.json", (text + "\n").encode())


def _page(study: Study[DatasetFile], rows: Sequence[Row], sources: Sequence[str]) -> str:
    model = study.model
    count = {split: sum(row["split"] == split for row in rows) for split in ("train", "val", "test")}
    lines = [
        f"# {study.name}",
        "",
        *([model.description, ""] if model.description else []),
        f"{len(rows)} samples of {model.crops.rows} × {model.crops.cols} photosites, written by {software()}: "
        + ", ".join(f"{number} {split}" for split, number in count.items())
        + ". No scene is in two splits.",
        "",
        f"Scenes: {', '.join(sorted({str(row['scene']) for row in rows}))}. What varies: "
        + (", ".join(model.vary) or "nothing")
        + ".",
        "",
        "| part | what |",
        "|---|---|",
        *(f"| {part} | {_PARTS[part]} |" for part in model.hold),
        "",
        "Electrons of a code are (code − black_level_dn − black_offsets_dn) · electrons_per_dn; clean and truth are",
        "electrons of light alone: no black level, noise, dark current, clipping. Rows of black_offsets_dn repeat from",
        "a sample's first photosite on; most sensors have none. In codes above black, where the light's mean is m, a",
        "code lies about m + dark_dn, off by a mean square of shot_dn · (m + dark_dn) + read_dn2 + (prnu · m)²",
        "+ dsnu_dn². The first two are new in every exposure, the others belong to a sensor (`serial`).",
        "`neutral_R` and so on: what a grey gives in each channel, over the most; white balance divides by it.",
        "A row of `manifest.parquet` (or `.csv`) has a sample's shard, its place in it, its window and all of these.",
        "",
        _layout(model.shards),
        "",
        *(f"* {split}: {pattern_of(rows, split)}" for split, number in count.items() if number),
        "",
        f"Licence of the data set: {model.licence or 'not stated (key licence of its file)'}.",
        "",
        *(f"* {source}" for source in sources),
    ]
    return "\n".join(lines) + "\n"


def pattern_of(rows: Sequence[Row], split: str) -> str:
    """Return the shards of a split as shells and webdataset write them, and their number of samples."""
    one = [row for row in rows if row["split"] == split]
    last = max(int(row["shard"]) for row in one)
    numbers = f"{{00000..{last:05d}}}" if last else "00000"
    suffix = ".tar" if str(one[0]["file"]).endswith(".tar") else ""
    return f"`{split}-{numbers}{suffix}`, {len(one)} samples"


def _layout(form: str) -> str:
    if form == "tar":
        return "`SPLIT-NUMBER.tar` holds KEY.PART.npy and KEY.json of its samples, as webdataset reads them."
    if form == "files":
        return "`SPLIT-NUMBER/` holds KEY.PART.npy and KEY.json of its samples."
    return (
        "`SPLIT-NUMBER-PART.npy` holds a part of all samples of a shard, `SPLIT-NUMBER.jsonl` a line of JSON for each."
    )


def _croissant(folder: Path, study: Study[DatasetFile], rows: Sequence[Row], sources: Sequence[str]) -> dict[str, Any]:
    """Return Croissant 1.0 metadata: the index as a record set, the shards as a set of files."""
    names = list(dict.fromkeys(name for row in rows for name in row if name not in ("status", "message", "frame")))
    fields = [
        {
            "@type": "cr:Field",
            "@id": f"samples/{name}",
            "name": name,
            "dataType": _type_of([row.get(name) for row in rows]),
            "source": {"fileObject": {"@id": "index"}, "extract": {"column": name}},
        }
        for name in names
    ]
    pattern = {"tar": "*.tar", "npy": "*.npy", "files": "*/*.npy"}[study.model.shards]
    return {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": study.name,
        "description": study.model.description or f"Raw captures with their truth, simulated by {software()}.",
        **({"license": study.model.licence} if study.model.licence else {}),
        "creditText": " ".join(sources),
        "url": "https://localhost/",
        "version": "1.0.0",
        "datePublished": "2000-01-01",
        "citeAs": f"{study.name}, made with {software()}",
        "distribution": [
            {
                "@type": "cr:FileObject",
                "@id": "index",
                "name": PARQUET,
                "contentUrl": PARQUET,
                "encodingFormat": "application/x-parquet",
                "sha256": sha256_of(folder / PARQUET),
            },
            {
                "@type": "cr:FileSet",
                "@id": "shards",
                "name": "shards",
                "encodingFormat": "application/x-tar" if pattern == "*.tar" else "application/octet-stream",
                "includes": pattern,
            },
        ],
        "recordSet": [{"@type": "cr:RecordSet", "@id": "samples", "name": "samples", "field": fields}],
    }


def _type_of(values: Sequence[Any]) -> str:
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return "sc:Float"
    return _TYPES.get(kinds.pop(), "sc:Text") if len(kinds) == 1 else "sc:Text"
