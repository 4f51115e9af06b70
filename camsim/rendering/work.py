"""Counts of a rendering's work, for reports, and to verify that work is omitted if a scene does not need it."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """Counts; a pure function of the inputs, and the same on any machine.

    shapes           : shapes of the scene
    outline_edges    : edges of all shapes' outlines, before one covers another
    edges            : edges that were rendered
    edges_equal      : not rendered: both sides have equal signals in every channel in this light
    edges_far        : not rendered: outside the window, all of them together below their share of the tolerance
    wavelengths      : those of the light that carry signal;  wavelength_nodes: those at which optics were computed
    channels         : images of the grid that were computed
    photosites       : values of a photosite in a channel that were computed
    tables           : tables of fields and edge responses;  table_values: numbers in them;  table_terms: terms summed
    nodes_integrated : quadrature nodes on edges near a photosite, as estimated (``cost.near_nodes``)
    frequencies      : frequencies summed by the Fourier engine
    samples          : samples taken by the sampling methods
    samples_of_pictures : samples of all visible pictures
    photosites_checked : computed again by the check
    random_numbers   : drawn for noise and fixed patterns, defects' places apart
    colour_matrices  : files with a fitted matrix;  bytes_written: size of all files (both known on the command line)
    """

    shapes: int = 0
    outline_edges: int = 0
    edges: int = 0
    edges_equal: int = 0
    edges_far: int = 0
    wavelengths: int = 0
    wavelength_nodes: int = 0
    channels: int = 0
    photosites: int = 0
    tables: int = 0
    table_values: int = 0
    table_terms: int = 0
    nodes_integrated: int = 0
    frequencies: int = 0
    samples: int = 0
    samples_of_pictures: int = 0
    photosites_checked: int = 0
    random_numbers: int = 0
    colour_matrices: int = 0
    bytes_written: int = 0

    def __add__(self, other: Work) -> Work:
        """Add up every count.

        >>> (Work(edges=2, samples=1) + Work(edges=3)).counts()
        {'edges': 5, 'samples': 1}
        """
        return Work(**{f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(self)})

    def counts(self) -> dict[str, int]:
        """Return the counts that are not zero."""
        return {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name)}
