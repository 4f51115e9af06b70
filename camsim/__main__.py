"""``python -m camsim``: the same as ``camsim``."""

from camsim.cli import main

if __name__ == "__main__":
    main()
