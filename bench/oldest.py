"""The oldest version of every package that pyproject.toml admits, as pip's constraints: python bench/oldest.py"""

import re
import tomllib
from pathlib import Path

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def oldest(requirement: str) -> str:
    """Return a requirement with its lower end as the only version: "numpy>=2.0" is numpy==2.0.*.

    >>> oldest("numba>=0.68,<0.69")
    'numba==0.68.*'
    """
    name, version = re.match(r"([\w.-]+)>=([\d.]+)", requirement).groups()
    return f"{name}=={version}.*" if version.count(".") < 2 else f"{name}=={version}"


if __name__ == "__main__":
    print("\n".join(oldest(requirement) for requirement in PROJECT["dependencies"]))
