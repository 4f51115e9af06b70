"""``python -m bench.scaling``: see measured.py, whose functions run in processes of their own too."""

from bench.scaling.measured import main

if __name__ == "__main__":
    main()
