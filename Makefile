# Everything runs in a virtual environment of its own; only Python (3.11 or later) and make are needed.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

.PHONY: demo gallery pictures docs test test-oldest dist-check test-clients test-bounds attack attack-quick mutants lint format bench bench-all extremes clean

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[test,lint]'
	touch $@

demo: $(READY)  ## capture the slanted edge with the D40-like sensor into out/
	mkdir -p out
	$(BIN)/camsim capture scenes/slanted-edge.yaml --sensor d40-like --force \
	  -o out/slanted-edge.dng -o out/slanted-edge.png -o out/slanted-edge.exr

gallery: $(READY)  ## every shipped scene as a picture, with its file and its twin in Python, into docs/gallery.md
	$(BIN)/python -m bench.gallery

docs: $(READY)  ## the site into out/site, to be opened as a file; warnings and dead links are errors
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	$(BIN)/python -m sphinx -q -W --keep-going -b html -d out/site-doctrees docs out/site
	$(BIN)/python docs/_ext/judge.py out/site

# Tests run on up to four processes side by side; they share nothing but the kernel cache.
SIDE_BY_SIDE := -n auto --maxprocesses 4 --dist worksteal

test: $(READY)
	$(BIN)/python -m pytest $(SIDE_BY_SIDE)

test-clients: $(READY)  ## judge the files by programs from elsewhere; a missing one is a failure, never a skip
	(for program in exiftool dcraw dcraw_emu rawtherapee-cli darktable-cli exrheader chromium; do \
	  command -v $$program >/dev/null || exit 1; done) || \
	  { apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
	    libimage-exiftool-perl dcraw libraw-bin rawtherapee darktable openexr chromium >/dev/null; }
	$(BIN)/python -m pip install --quiet --editable '.[clients]'
	$(BIN)/python -m pytest -m clients $(SIDE_BY_SIDE)

test-bounds: $(READY)  ## the kernels with every array index checked (compiled apart, a minute)
	NUMBA_BOUNDSCHECK=1 NUMBA_CACHE_DIR=$(VENV)/bounds-checked $(BIN)/python -m pytest -q \
	  tests/convergence/test_random_scenes.py tests/analytic/test_rendering_truth.py

dist-check: $(READY)  ## build the wheel and the sdist, install each where nothing else is, try them; a quarter of an hour
	$(BIN)/python -m pip install --quiet build
	$(BIN)/python bench/dist_check.py $(TESTS)

attack: $(READY)  ## random systems against independent truths, ten minutes; SEED=… COUNT=… draws others (docs/attack.md)
	NUMBA_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m tests.attack --seconds 600 \
	  $(if $(SEED),--seed $(SEED)) $(if $(COUNT),--count $(COUNT))

attack-quick: $(READY)  ## the first few dozen of today's
	NUMBA_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m tests.attack --quick --count 60 --seconds 60

mutants: $(READY)  ## one line of camsim changed at a time: do the tests notice? (docs/mutants.md; an hour or two, goes on where it was)
	NUMBA_NUM_THREADS=1 $(BIN)/python bench/mutants

bench: $(READY)  ## the paper's square beside GalSim and prysm, a minute, into out/bench (camsim bench SCENE: your own scene)
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m bench.paper --quick --peers -o out/bench

bench-all: $(READY)  ## every system, setting and program, the paper's tables, half an hour
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m bench.paper --peers -o out/bench

extremes: $(READY)  ## every stiff and extreme case, into out/extremes; fails when one is wrong
	$(BIN)/python -m pip install --quiet --editable '.[bench]'
	$(BIN)/python -m bench.extremes -o out/extremes

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:
	rm -rf $(VENV) out dist build
