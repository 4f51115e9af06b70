"""What is compiled ahead is what a capture takes: after it no kernel meets a type that it has not met.

And the next capture imports nothing that takes long and is of no use to it.
"""

import subprocess
import sys
from pathlib import Path

CODE = """
import sys
from camsim.core.kernels.dispatch import _Kernel
from camsim.rendering.first_use import compile_check, compile_kernels
import camsim.api

def types():
    modules = [module for name, module in list(sys.modules.items()) if name.startswith("camsim.")]
    kernels = {k for module in modules for k in vars(module).values() if isinstance(k, _Kernel)}
    return {(kernel.py_func.__qualname__, types) for kernel in kernels for types in kernel.signatures}

compile_kernels()
compile_check()
ahead = types()
camsim.api.capture("slanted-edge", overrides=["region.rows=24", "region.cols=24"])
print(len(ahead), [name for name, _ in types() - ahead])
"""
NEXT = """
import sys
from camsim.cli import main
sys.argv = ["camsim", "capture", "slanted-edge", "--set", "region={rows: 24, cols: 24}", "-q"]
try:
    main()
finally:
    print(*sys.modules)
"""
NOT_NEEDED = {
    *("scipy.special", "scipy.fft", "scipy.linalg", "statistics", "rich"),
    *("camsim.rendering.varying", "camsim.rendering.waves.field_lens", "camsim.rendering.waves.bent_fields"),
}


def test_a_capture_takes_nothing_that_was_not_compiled_ahead(tmp_path: Path) -> None:
    said = subprocess.run([sys.executable, "-c", CODE], check=True, capture_output=True, text=True).stdout
    count, _, more = said.strip().partition(" ")
    assert int(count) >= 8
    assert more == "[]"
    warm = subprocess.run([sys.executable, "-c", NEXT], check=True, capture_output=True, text=True, cwd=tmp_path)
    assert set(warm.stdout.split()) & NOT_NEEDED == set()
    assert (tmp_path / "slanted-edge.dng").exists()
