"""Scenes and optics that many tests look at, in pitches, and the shortest way from there to an image.

With a pitch of 4 µm and 500 nm, λN is an eighth of the f-number in pitches.
"""

import numpy as np

import camsim

PITCH_UM = 4.0
WAVELENGTH_NM = 500.0
TOLERANCE = 1e-6

# From short waves on a small photosite to long ones on a point; λN = 0.175, 1, 1 and 6 pitches.
OPTICS = {
    "f/1.4, fill factor 0.5": [
        camsim.Airy(f_number=1.4),
        camsim.SquarePhotosite.from_fill_factor(pitch_um=PITCH_UM, fill_factor=0.5),
    ],
    "f/8": [camsim.Airy(f_number=8.0), camsim.SquarePhotosite(side_um=PITCH_UM)],
    "f/8, OLPF": [
        camsim.Airy(f_number=8.0),
        camsim.FourSpotOlpf(split_um=0.75 * PITCH_UM),
        camsim.SquarePhotosite(side_um=PITCH_UM),
    ],
    "f/48, point": [camsim.Airy(f_number=48.0)],
}

# No symmetry, a concave corner, an overlap, corners on and off the grid of photosites.
ARROW = np.array([(-7.3, -5.0), (6.2, -1.5), (-4.6, 7.1), (-2.25, 0.4)])
TRIANGLE = np.array([(1.0, -6.5), (8.5, 2.0), (0.2, 3.3)])
SLAB = np.array([(-9.0, 4.5), (2.0, 8.25), (1.5, 10.0), (-9.5, 6.25)])
PICTURE = [(ARROW, 0.9), (TRIANGLE, 0.05), (SLAB, 0.5)]
BACKGROUND = 0.3


def scene_of(shapes, background=BACKGROUND):
    """Scene of (corners in pitches, reflectance) pairs, in painter's order."""
    return camsim.Scene(
        background=background,
        shapes=[
            camsim.Polygon(points_um=np.asarray(corners) * PITCH_UM, reflectance=reflectance)
            for corners, reflectance in shapes
        ],
    )


def grid_of(rows, cols, **window):
    return camsim.Grid(rows=rows, cols=cols, pitch_um=PITCH_UM, **window)


def image_of(shapes, optics, rows=20, cols=24, *, background=BACKGROUND, tolerance=TOLERANCE, **window):
    """Image of (corners in pitches, reflectance) pairs."""
    rendering = camsim.render(
        scene_of(shapes, background),
        optics,
        grid_of(rows, cols, **window),
        wavelength_nm=WAVELENGTH_NM,
        tolerance=tolerance,
    )
    assert rendering.error_estimate <= tolerance
    return rendering.image


def moved(shapes, matrix=((1, 0), (0, 1)), shift=(0.0, 0.0)):
    """Every corner times a matrix, then shifted."""
    return [(np.asarray(corners) @ np.array(matrix, float).T + shift, reflectance) for corners, reflectance in shapes]


def worst(a, b):
    """Largest difference of two images; a NaN is never small."""
    difference = np.abs(np.asarray(a) - np.asarray(b)).max()
    return np.inf if np.isnan(difference) else difference


def tile_centres(shape, step, centre, rotate_deg):
    """Centres (rows, cols, 2) of squares side by side about ``centre``; corners that they share differ by rounding."""
    turn = np.radians(rotate_deg)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    places = [
        [[col + 0.5 - shape[1] / 2, row + 0.5 - shape[0] / 2] for col in range(shape[1])] for row in range(shape[0])
    ]
    return np.array([[centre + step * np.array(place) @ axes for place in row] for row in places])


def tiles(reflectance, step_um, centre_um, rotate_deg):
    """Squares side by side, each of its own grey (rows, cols)."""
    centres = tile_centres(reflectance.shape, step_um, np.asarray(centre_um), rotate_deg)
    return [
        camsim.Rectangle(
            width_um=step_um,
            height_um=step_um,
            centre_um=tuple(centres[place]),
            rotate_deg=rotate_deg,
            reflectance=float(reflectance[place]),
        )
        for place in np.ndindex(reflectance.shape)
    ]
