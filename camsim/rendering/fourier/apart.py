"""An image's parts: by distance, or by place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from camsim.arrays import F64
from camsim.optics import OpticalSystem
from camsim.rendering.edges import Edges
from camsim.rendering.engine import Cost
from camsim.rendering.fourier.islands import islands
from camsim.rendering.fourier.rim import RimLight, rim_hems
from camsim.rendering.fourier.shells import Shell, shells
from camsim.rendering.fourier.sight import Sight
from camsim.rendering.fourier.spikes import Spikes, spike_hem
from camsim.rendering.fourier.spread import Kernel
from camsim.rendering.fourier.taper import Hem
from camsim.rendering.fourier.together import Part, Sum, pays
from camsim.rendering.hearing import Hearing

SOON = 0.03  # seconds, for which nobody is asked: asking takes 5 ms, and of less than this no part saved any


class Whole(Protocol):
    """An image as far as its parts depend on it; see ``FourierImage``."""

    @property
    def edges(self) -> Edges: ...  # noqa: D102
    @property
    def system(self) -> OpticalSystem: ...  # noqa: D102
    @property
    def pitch_um(self) -> float: ...  # noqa: D102
    @property
    def tolerance(self) -> float: ...  # noqa: D102
    @property
    def memory_limit_bytes(self) -> float: ...  # noqa: D102
    @property
    def quiet(self) -> Callable[[], float] | None: ...  # noqa: D102
    @property
    def hearing(self) -> Hearing: ...  # noqa: D102
    @property
    def kernel(self) -> Kernel: ...  # noqa: D102
    @property
    def lit(self) -> tuple[F64, F64]: ...  # noqa: D102
    @property
    def footprint(self) -> F64: ...  # noqa: D102
    @property
    def whole(self) -> object | None: ...  # noqa: D102
    @property
    def undivided(self) -> bool: ...  # noqa: D102

    def at_once(self, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Cost, float]: ...  # noqa: D102

    def shell_of(self, shell: Shell) -> Part: ...  # noqa: D102

    def island_of(self, edges: Edges, islands: int) -> Part: ...  # noqa: D102


def parts_of(image: Whole, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
    """Return the parts of an image that take less than all at once; none where there are no such."""
    cost = image.at_once(origin, shape)[0]
    if (image.undivided or cost.seconds <= SOON) and cost.memory_bytes <= image.memory_limit_bytes:
        return ()
    ways = [way for way in (*by_distance(image, origin, shape), by_place(image, origin, shape)) if way]
    best: tuple[Part, ...] = ()
    for way in ways:
        own = Sum(parts=way).expected(origin, shape)[0]
        if pays(own, cost, image.memory_limit_bytes):
            best, cost = way, own
    return best


def by_distance(image: Whole, origin: tuple[float, float], shape: tuple[int, int]) -> list[tuple[Part, ...]]:
    """Return ways: shells of a round pattern; of others what is near, and their spikes or the light of their rims."""
    wavelength_nm, density = image.lit
    sight = Sight(
        system=image.system,
        kernel=image.kernel,
        wavelength_nm=wavelength_nm,
        pitch_um=image.pitch_um,
        edges=image.edges.seen_from(origin),
        shape=shape,
        tolerance=image.tolerance,
        hearing=image.hearing,
    )

    def thrown(by: Callable[..., Part], hem: Hem, **own: float) -> tuple[Part, ...]:
        """Return what is near, and what throws the light from beyond a taper."""
        far = by(
            edges=image.edges,
            density=density,
            wavelength_nm=wavelength_nm,
            system=image.system,
            pitch_um=image.pitch_um,
            hem=hem,
            **own,
        )
        return image.shell_of(Shell(begin=None, end=hem, tapers=1)), far

    if spikes_from := spike_hem(sight):
        return [thrown(Spikes, spikes_from)]
    hems = rim_hems(sight)
    ways = [thrown(RimLight, hem, directions=directions, leave=leave) for hem, directions, leave in hems]
    return ways or [tuple(image.shell_of(shell) for shell in shells(sight, image.quiet))]


def by_place(image: Whole, origin: tuple[float, float], shape: tuple[int, int]) -> tuple[Part, ...]:
    """Return islands of the scene, of a lens whose pattern is sampled; an island has none."""
    if image.whole is not None or not image.kernel.sampled:
        return ()
    own = islands(image.edges, (origin, shape), image.kernel, image.lit[0].size, image.footprint)
    if len(own) < 2:
        return ()
    return tuple(image.island_of(one, len(own)) for one in own)
