"""What is done once before any ``camsim`` is forked (forked.py): imports, judges of files, kernels read from the cache.

Nothing is computed, and no thread begun: a fork would inherit its locks and not it.
"""

import importlib
import pkgutil
import subprocess
import sys

import camsim
from camsim.config.schema import SceneFile, SensorFile
from camsim.core.kernels.dispatch import _Kernel
from camsim.rendering import kernels_compiled

LIBRARIES = (
    *("matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg"),
    *("numba.np.arraymath", "scipy.linalg", "scipy.special", "rich.table", "colour"),
)
AHEAD = "from camsim.rendering.first_use import *; compile_kernels(); compile_check()"

for module in pkgutil.walk_packages(camsim.__path__, "camsim."):
    if module.name not in ("camsim.cli.app", "camsim.__main__"):  # which note when they began
        importlib.import_module(module.name)
for library in LIBRARIES:
    importlib.import_module(library)
for judge in (SceneFile, SensorFile):
    judge.model_rebuild()
if not kernels_compiled():
    subprocess.run([sys.executable, "-c", AHEAD], check=True)
for module in [module for name, module in list(sys.modules.items()) if name.startswith("camsim.")]:
    for kernel in [value for value in vars(module).values() if isinstance(value, _Kernel)]:
        if kernel.cache is not None:
            for types, *_ in kernel.cache._cache_file._load_index():
                kernel.compile(types)
