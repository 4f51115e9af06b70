"""camsim: a spectral camera that runs from a YAML file.

The public names, which ``__init__.pyi`` lists, load when they are first used: ``import camsim`` itself is nearly free.
"""

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    found = _load(name)
    if isinstance(found, type):
        from camsim.core.calls import constructors_in_words

        constructors_in_words(found)
    globals()[name] = found
    return found
