"""camsim: a spectral camera that runs from a YAML file.

The public names, which ``__init__.pyi`` lists, load when they are first used: ``import camsim`` itself is nearly free.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
