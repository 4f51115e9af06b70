"""Frame: what the camera recorded, and the metadata that files carry."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from camsim.core import notebook
from camsim.core.arrays import F32, F64, I64, U8, U16, is_masked
from camsim.core.doors import above
from camsim.core.note import Note
from camsim.core.number_kinds import array_of
from camsim.core.typed import LARGEST_FRAME_NUMBER, Count, Whole, check, known_name
from camsim.core.words import displayed
from camsim.errors import InvalidValueError
from camsim.sensor.adc import full_codes
from camsim.sensor.colour_matrix import ColourResponse
from camsim.sensor.companding import data_numbers

if TYPE_CHECKING:
    from camsim.rendering.cube import SpectralCube


Product: TypeAlias = Literal["mosaic", "electrons", "truth", "spectral", "preview", "frame"]
Products: TypeAlias = tuple[Product, ...] | Collection[Product]
"""Several products; the tuple type lets type checkers verify literals."""

PRODUCTS: Mapping[Product, str] = {
    "mosaic": "the sensor's codes",
    "electrons": "each photosite's own electrons",
    "truth": "mean electrons of every channel at every photosite, before noise",
    "spectral": "the scene's radiance per wavelength, through the optics",
    "preview": "developed sRGB, to look at",
    "frame": "mosaic, electrons and, when captured, truth, with the record, as numpy arrays",
}
"""Products of a capture, each of which a file can hold."""

LARGEST_CODE = 65535

STREAMED = ("mosaic", "spectral")
"""Products that a capture can give without holding arrays of photosites."""


def check_products(products: Collection[str], *, streamed: bool = False) -> None:
    """Raise for unknown product names, and for products that cannot be streamed if ``streamed``.

    A bare string is refused: a tuple of one was probably meant.
    """
    if not isinstance(products, Collection):
        raise InvalidValueError(f"must be a list of names, not {displayed(products)}", key="products")
    for product in (products,) if isinstance(products, str) else products:
        known_name("product", product, PRODUCTS, "products")
    if isinstance(products, str):
        raise InvalidValueError(
            f"{products!r} is one name; give several in a tuple, such as ({products!r},)", key="products"
        )
    if streamed and not set(products) <= set(STREAMED):
        said = f"{', '.join(products)}; row by row there are {' and '.join(STREAMED)}"
        raise InvalidValueError(said, key="products")


def frame_numbers(first: int, count: Whole) -> range:
    """Return the numbers of one frame or several; raises above the largest number that files can have.

    >>> list(frame_numbers(3, 2))
    [3, 4]
    """
    check(count, Count, "count", "Capture.frames")
    if first + count - 1 > LARGEST_FRAME_NUMBER:
        message = (
            f"{first}, and {count} frames from there on; {LARGEST_FRAME_NUMBER} is the last, begin at a smaller one"
        )
        raise InvalidValueError(message, key="frame_number", stage="Capture")
    return range(first, first + count)


def codes_of(mosaic: ArrayLike, stage: str = "") -> U16:
    """Return codes (rows, cols) as files hold them; raises for numbers that would be truncated or wrap."""
    if is_masked(mosaic):
        message = "has masked photosites; fill them, in numpy by .filled(…)"
        raise InvalidValueError(message, key="mosaic", stage=stage)
    codes = array_of(mosaic, "mosaic", stage)
    if codes.ndim != 2:
        raise InvalidValueError(
            f"must be (rows, cols), one code for each photosite, not an array of shape {codes.shape}",
            key="mosaic",
            stage=stage,
        )
    if codes.dtype.kind not in "ui":
        raise InvalidValueError(
            f"must be whole numbers, not {codes.dtype}; scale to data numbers first: "
            "np.rint(black + signal * (white - black)).astype(np.uint16)",
            key="mosaic",
            stage=stage,
        )
    if codes.size and codes.dtype != np.uint16:
        low, high = int(codes.min()), int(codes.max())
        if low < 0 or high > LARGEST_CODE:
            message = f"codes must be 0 to {LARGEST_CODE}, not {low if low < 0 else high}"
            raise InvalidValueError(message, key="mosaic", stage=stage)
    return codes.astype(np.uint16, copy=False)


@dataclass(frozen=True, kw_only=True)
class ChannelSignal:
    """Signal of one colour channel over the photosites that carry it."""

    name: str
    mean_e: float
    max_e: float
    mean_dn: float
    clipped_photosites: int
    photosites: int
    min_e: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Report:
    """What a capture computed, and its error; ``seconds`` is the only part that differs between equal captures.

    standard_error : for sampling methods only, see ``camsim.Rendering``
    work           : counts of what was computed, see ``camsim.rendering.work``

    >>> import camsim
    >>> frame = camsim.capture("flat-field", overrides=["region={rows: 2, cols: 2}", "render.tolerance=1e-2"])
    >>> frame.report.error_estimate <= frame.report.tolerance
    True
    >>> [signal.name for signal in frame.report.signal]
    ['R', 'G', 'B']
    """

    scene: str
    optics: tuple[str, ...]
    electronics: tuple[str, ...] = ()
    wavelengths: str
    method: str
    tolerance: float
    error_estimate: float
    checked_photosites: int
    truth_error_estimate: float | None = None
    standard_error: float | None = None
    work: Mapping[str, int] = field(default_factory=dict)
    signal: tuple[ChannelSignal, ...]
    seconds: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()

    def __repr__(self) -> str:
        notes = f", {len(self.notes)} notes" if self.notes else ""
        if self.method == "none":
            return f"Report({self.scene}: nothing rendered{notes})"
        return f"Report({self.scene}: {self.method}, error {self.error_estimate:.2g} of {self.tolerance:g}{notes})"

    def rows(self) -> Iterator[tuple[str, str]]:
        """Yield name and text of each entry, for display in notebooks."""
        yield "optics", " → ".join(self.optics)
        if self.electronics:
            yield "electronics", " → ".join(self.electronics)
        yield "wavelengths", self.wavelengths
        if self.method != "none":
            error = f"error {self.error_estimate:.2g} of {self.tolerance:g} at {self.checked_photosites} photosites"
            yield "rendering", f"{self.method}, {error}"
        for channel in self.signal:
            clipped = f", {channel.clipped_photosites} of {channel.photosites} clipped"
            yield (
                f"signal of {channel.name}",
                f"mean {channel.mean_e:.1f} e⁻ ({channel.mean_dn:.1f} DN), most {channel.max_e:.1f} e⁻"
                f"{clipped if channel.clipped_photosites else ''}",
            )
        for note in self.notes:
            yield "note", note.text

    def _repr_html_(self) -> str:
        return notebook.table(self.rows(), self.scene)


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """A finished capture.

    mosaic              (rows, cols) uint16 stored codes; ``signal_dn`` and ``signal_e`` are their data numbers minus
                        black, as floats
    mean_electrons      (rows, cols) float64, before any noise, after crosstalk, each photosite in its own channel
    electrons           (rows, cols) float64, after noise and full well, before the ADC
    truth               (rows, cols, channels) float32 mean electrons of every channel; None unless requested. At a
                        photosite's channel it equals ``mean_electrons``; at others, what a photosite of that channel
                        would collect there, with the neighbours (for crosstalk) it has in the array
    channel_index       (rows, cols) uint8, index into ``channels``
    channels            names such as ("R", "G", "B") or ("Y",)
    cfa_pattern         letters from the window's (0,0) (0,1) … , one string per row, such as ("RG", "GB")
    black_offsets_dn    added to the black level, tiled from the window's (0,0); usually 0 everywhere
    white_level_dn      code at which a photosite without an offset is full; ``white_levels_dn``: of each offset,
                        as ``black_levels_dn``
    electrons_per_dn    at the ISO setting of the exposure
    white_e             mean electrons at which white clips, for a non-linear read-out; None: from white_level_dn
    shot_e2_per_e       variance of shot noise per electron of signal as read, at 18 % of black..white: 1 for a linear
                        read-out; 0 without shot noise
    read_noise_e        standard deviation of the total temporal read-out noise
    steps_e             quantisation step of each channel's electrons in 64-bit files: finer digits differ between
                        processors; empty: not quantised
    f_number            of the lens; 0: no lens
    companding          (data number, code) points where stored codes are companded; all levels are data numbers, and
                        ``linear_dn`` gives the mosaic in them
    frame_number        index of the exposure among those of one scene
    spectral            the scene's radiance per wavelength; None unless requested
    passed_rows         number of rows of a streamed capture, whose arrays are empty
    colour              spectral response of the channels after crosstalk: for colour matrices and white balance
    description         plain tree (dicts, lists, numbers, strings) of all stages and parameters

    >>> import camsim
    >>> frame = camsim.capture("flat-field", overrides=["region={rows: 2, cols: 2}", "render.tolerance=1e-2"])
    >>> frame.mosaic.shape, frame.channels, frame.cfa_pattern
    ((2, 2), ('R', 'G', 'B'), ('RG', 'GB'))
    >>> frame.black_level_dn, frame.electrons_per_dn
    (128, 10.0)
    >>> frame.signal_dn.dtype, frame.signal_e.shape
    (dtype('float64'), (2, 2))
    """

    mosaic: U16
    mean_electrons: F64
    electrons: F64
    truth: F32 | None
    channel_index: U8
    channels: tuple[str, ...]
    cfa_pattern: tuple[str, ...]
    pitch_um: float
    bit_depth: int
    black_level_dn: int
    white_level_dn: int
    electrons_per_dn: float
    white_e: float | None = None
    shot_e2_per_e: float = 1.0
    read_noise_e: float
    camera_name: str
    serial: int
    f_number: float
    time_s: float
    iso: float
    datetime: str
    seed: int
    frame_number: int = 0
    black_offsets_dn: tuple[tuple[int, ...], ...] = ((0,),)
    companding: tuple[tuple[int, int], ...] = ()
    steps_e: tuple[float, ...] = ()
    spectral: SpectralCube | None = None
    passed_rows: int = 0
    colour: ColourResponse
    description: Mapping[str, Any]
    report: Report

    def __post_init__(self) -> None:
        object.__setattr__(self, "mosaic", codes_of(self.mosaic, "Frame"))
        if self.passed_rows:
            return
        size = self.mosaic.shape
        sizes = {"mean_electrons": size, "electrons": size, "channel_index": size}
        if self.truth is not None:
            sizes["truth"] = (*size, len(self.channels))
        for key, wanted in sizes.items():
            array = getattr(self, key)
            if not isinstance(array, np.ndarray) or array.shape != wanted or array.dtype.kind not in "fiu":
                message = f"must be numbers of shape {wanted}, as the mosaic has photosites, not {displayed(array)}"
                raise InvalidValueError(message, key=key, stage="Frame")

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols) of the window, also of a streamed capture."""
        return self.passed_rows + self.mosaic.shape[0], self.mosaic.shape[1]

    @property
    def black_levels_dn(self) -> I64:
        """Black levels, one for each of ``black_offsets_dn``."""
        levels: I64 = self.black_level_dn + np.array(self.black_offsets_dn)
        return levels

    @property
    def linear_dn(self) -> U16:
        """(rows, cols) data numbers: the mosaic, decompanded if it was companded."""
        linear: U16 = data_numbers(self.companding, self.mosaic)
        return linear

    @property
    def signal_dn(self) -> F64:
        """(rows, cols) float64: data numbers minus each photosite's black level; noise makes some negative.

        ``mosaic - black_level_dn`` is not the same: codes are unsigned, and values below black wrap around to 65 535.
        """
        black_dn = self.black_levels_dn.astype(np.float64)
        tiles = [-(-size // period) for size, period in zip(self.mosaic.shape, black_dn.shape, strict=True)]
        signal: F64 = self.linear_dn - np.tile(black_dn, tiles)[: self.mosaic.shape[0], : self.mosaic.shape[1]]
        return signal

    @property
    def signal_e(self) -> F64:
        """(rows, cols) float64: ``signal_dn`` in electrons, as read; a non-linear response is not inverted."""
        signal: F64 = self.signal_dn * self.electrons_per_dn
        return signal

    @property
    def white_levels_dn(self) -> I64:
        """White levels, one for each of ``black_offsets_dn``, which shift white as they shift black."""
        return full_codes(self.white_level_dn, self.black_offsets_dn, (1 << self.bit_depth) - 1)

    @property
    def clips_at_e(self) -> float:
        """Mean electrons at which white clips."""
        linear_e = (self.white_level_dn - self.black_level_dn) * self.electrons_per_dn
        return linear_e if self.white_e is None else self.white_e

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        product: Product | None = None,
        force: bool = False,
        allow_odd_cfa: bool = False,
        compress: bool = False,
    ) -> None:
        """Write one product; the suffix chooses the format: see ``camsim.save``."""
        save = above("files.save")
        save(self, path, product=product, force=force, allow_odd_cfa=allow_odd_cfa, compress=compress)

    def preview(self) -> U8:
        """Return (rows, cols, 3) sRGB for viewing: developed as by a raw developer, grey for one channel."""
        developed: U8 = above("files.preview.develop")(self)
        return developed if developed.ndim == 3 else np.repeat(developed[..., None], 3, axis=2)

    def __repr__(self) -> str:
        (rows, cols), pattern = self.shape, "/".join(self.cfa_pattern)
        more = ", with its truth" if self.truth is not None else ""
        return (
            f"Frame({rows} × {cols} photosites of {self.camera_name}, {pattern}, {self.bit_depth} bits, "
            f"{self.time_s:.4g} s, ISO {self.iso:g}, seed {self.seed}{more})"
        )

    def _repr_png_(self) -> bytes | None:
        picture: bytes | None = None if self.passed_rows else above("files.png.picture")(self.preview())
        return picture

    def _repr_html_(self) -> str:
        rows, cols = self.shape
        lines = [
            ("photosites", f"{rows} × {cols} of {self.pitch_um:g} µm, {'/'.join(self.cfa_pattern)}"),
            ("camera", f"{self.camera_name}, {self.bit_depth} bits, {self.electrons_per_dn:.4g} e⁻ per DN"),
            ("exposure", f"{self.time_s:.6g} s, f/{self.f_number:g}, ISO {self.iso:g}, seed {self.seed}"),
            *self.report.rows(),
        ]
        return notebook.image(self._repr_png_()) + notebook.table(lines)
