"""Noise of the read-out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from annotated_types import Ge, Gt, Le

from camsim.core.arrays import F64
from camsim.core.typed import NonNegative, Number, refusal, validate
from camsim.core.words import brief
from camsim.sensor.stage import Context, ElectronicStage, add_normals

_FINEST = 2.0**-53
"""Smallest distance of a probability from 0 or 1."""


@dataclass(frozen=True, slots=True)
class ReadNoise(ElectronicStage):
    """Noise of the read-out, referred to electrons: normal, or with heavy tails, alike for all photosites or not.

    sigma_e       : standard deviation, electrons, for every distribution; with ``spread`` the root mean variance
    student_dof   : degrees of freedom of Student's t, above 2; smaller means heavier tails
    tukey_lambda  : shape of Tukey's λ law, the quantiles of which are (pˡ − (1 − p)ˡ)/l: 0.13 is nearly normal, 0 the
                    logistic law, and the further below 0 the heavier the tails
    spread        : standard deviation of the logarithm of each photosite's standard deviation, a fixed pattern

    >>> ReadNoise(2.4).dark_noise_e(2.7)
    2.4
    >>> ReadNoise(2.4, student_dof=5.0)
    ReadNoise(sigma_e=2.4, student_dof=5.0)
    """

    name: ClassVar = "read_noise"
    stream: ClassVar = 3, 12
    temporal: ClassVar = True

    sigma_e: NonNegative
    student_dof: Annotated[float, Gt(2), Le(1000)] | None = field(default=None, metadata={"described": "if any"})
    tukey_lambda: Annotated[float, Gt(-0.5), Le(0.2)] | None = field(default=None, metadata={"described": "if any"})
    spread: Annotated[float, Ge(0), Le(2)] = field(default=0.0, metadata={"described": "if any"})

    if TYPE_CHECKING:

        def __init__(
            self,
            sigma_e: Number,
            student_dof: Number | None = None,
            tukey_lambda: Number | None = None,
            spread: Number = 0.0,
        ) -> None: ...

    __repr__ = brief

    def __post_init__(self) -> None:
        validate(self)
        if self.student_dof is not None and self.tukey_lambda is not None:
            raise refusal(
                self, "tukey_lambda", "given together with student_dof, another law; leave one of the two out"
            )

    def apply(self, electrons: F64, context: Context) -> F64:
        """Add noise; charge may come out below zero."""
        rng, shape = context.generator(self.stream[0]), electrons.shape
        if self.student_dof is not None:
            one: F64 = rng.standard_t(self.student_dof, shape)
            one *= self.sigma_e * math.sqrt(1.0 - 2.0 / self.student_dof)
        elif self.tukey_lambda is not None:
            one = tukey_quantiles(np.clip(rng.random(shape), _FINEST, 1.0 - _FINEST), self.tukey_lambda)
            one *= self.sigma_e / tukey_sigma(self.tukey_lambda)
        else:
            normals = rng.standard_normal(shape, dtype=np.float32)
            if not self.spread:
                return add_normals(electrons, self.sigma_e, normals)
            one = self.sigma_e * normals.astype(np.float64)
        if self.spread:
            one *= np.exp(self.spread * context.normals(self.stream[1], shape).astype(np.float64) - self.spread**2)
        one += electrons
        return one

    def draws(self, shape: tuple[int, int], context: Context) -> int:
        """Return one number for each photosite, plus the normals of the pattern."""
        return shape[0] * shape[1] + (context.normals_drawn(shape[0]) if self.spread else 0)

    def dark_noise_e(self, electrons_per_dn: float) -> float:
        """Return the standard deviation of the noise, electrons."""
        return self.sigma_e


def tukey_quantiles(probability: F64, tukey_lambda: float) -> F64:
    """Return the quantiles of Tukey's λ law at probabilities between 0 and 1; at λ = 0 they are the logistic law's.

    >>> tukey_quantiles(np.array([0.5, 0.9]), 0.0).round(4)
    array([0.    , 2.1972])
    """
    if abs(tukey_lambda) < 1e-9:
        logistic: F64 = np.log(probability / (1.0 - probability))
        return logistic
    powers: F64 = (probability**tukey_lambda - (1.0 - probability) ** tukey_lambda) / tukey_lambda
    return powers


def tukey_sigma(tukey_lambda: float) -> float:
    """Return the standard deviation of Tukey's λ law (λ above −½).

    >>> round(tukey_sigma(0.0) / math.pi * math.sqrt(3.0), 6)
    1.0
    """
    if abs(tukey_lambda) < 1e-4:
        return math.pi / math.sqrt(3.0) * (1.0 - 1.7308 * tukey_lambda)
    both = math.gamma(tukey_lambda + 1.0) ** 2 / math.gamma(2.0 * tukey_lambda + 2.0)
    return math.sqrt(2.0 / tukey_lambda**2 * (1.0 / (1.0 + 2.0 * tukey_lambda) - both))
