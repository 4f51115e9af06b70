"""The camera: a body that takes pictures."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

from camsim.camera.body import Body
from camsim.camera.capture import Capture, Method
from camsim.camera.frame import Frame, Products
from camsim.camera.notes import notes_of_sensor
from camsim.camera.window import Region
from camsim.core.doors import above
from camsim.core.note import Note
from camsim.core.typed import Number, Several, Truth, Whole
from camsim.core.words import brief
from camsim.optics import Lens
from camsim.scene import Scene
from camsim.sensor.colour_matrix import MatrixOf
from camsim.sensor.exposure import Exposure
from camsim.spectra.light import Light


@dataclass(frozen=True, kw_only=True, init=False)
class Camera(Body):
    """A lens and a sensor, stage by stage; a stage that is None is left out.

    name, serial : name of the model, written to files; number of the specimen, which seeds its fixed patterns
    rows, cols   : size of the full frame
    pitch_um     : distance between photosites
    lens, extra_optics, olpf, photosite : optical stages; custom ones besides the lens
    cfa, quantum_efficiency, filters    : channels, their electrons per photon, and transmissions in front of the sensor
    colour_matrices : measured on a chart; written to files in place of fitted ones
    magnification, falloff : image size over object size, in brightness and blur; relative illumination
    veiling_glare  : fraction of the light that is spread evenly over the frame
    extra_stages   : custom electronic stages
    dual_gain, adc : conversion gain by ISO, and electrons to codes

    An electronic stage is an instance of its class: ``read_noise=ReadNoise(3.0)``, ``prnu=Prnu(0.006)``, and so on.
    Invalid values raise InvalidValueError with the field's name.

    >>> import camsim
    >>> camera = camsim.Camera.from_yaml("mono-345", lens=camsim.Airy(f_number=4.0))
    >>> camera.rows, camera.cols, camera.pitch_um
    (2048, 2448, 3.45)
    >>> camera.replace(full_well=camsim.FullWell(5000.0)).full_well
    FullWell(capacity_e=5000.0)
    """

    __repr__ = brief

    @classmethod
    def from_yaml(cls, sensor: str | os.PathLike[str], *, lens: Lens) -> Camera:
        """Return the camera of a sensor file (a path, or the name of a shipped one) behind ``lens``."""
        camera: Camera = above("api.load_camera")(sensor, lens=lens)
        return camera

    @property
    def notes(self) -> tuple[Note, ...]:
        """Likely errors in copying a data sheet, such as a PRNU in per cent; ``camsim validate`` prints them."""
        return tuple(notes_of_sensor(self))

    def expose(
        self,
        scene: Scene,
        *,
        light: Light,
        exposure: Exposure,
        seed: Whole = 0,
        frame_number: Whole = 0,
        region: Region | None = None,
        tolerance: Number = 1e-6,
        method: Method = "auto",
        strict: Truth = False,
        noise: Truth = True,
        colour_matrix: MatrixOf = "standard",
        spectral_nm: Several[Number] | None = None,
        scene_name: str = "scene",
        products: Products = ("mosaic",),
        progress: Callable[[str, float], None] | None = None,
    ) -> Frame:
        """Take a picture; the arguments are those of ``Capture`` and of ``Capture.frame``.

        ``Capture`` can also take several pictures of a scene (``frames``), or one larger than memory (``rows``).
        """
        capture = Capture(
            camera=self,
            scene=scene,
            light=light,
            exposure=exposure,
            seed=seed,
            frame_number=frame_number,
            region=region,
            tolerance=tolerance,
            method=method,
            strict=strict,
            noise=noise,
            colour_matrix=colour_matrix,
            spectral_nm=spectral_nm,
            scene_name=scene_name,
        )
        return capture.frame(products=products, progress=progress)
