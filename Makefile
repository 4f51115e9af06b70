# Everything runs in a virtual environment of its own; only Python (3.11 or later) and make are needed.
PYTHON ?= python3
VENV   ?= .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready

# Where an environment forbids Python to keep what it compiled, every command of a test takes a third of a second more.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo gallery pictures docs test test-quick test-oldest test-machines dist-check test-clients test-bounds attack attack-quick mutants lint format bench bench-all extremes clean

$(READY): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --editable '.[test,lint]'
	touch $@

DAYLIGHT := --sensor d40-like --set "light={illuminant: D55, illuminance_lux: 3000}" --force
ABERRATED := {kind: wavefront, f_number: 4, zernike_waves: [[8, 0.1]], defocus_um: 6}
ZONES := --set "region={rows: 150, cols: 150}" --set scene.shapes.0.radius=72 --set scene.shapes.0.rim_period=1.1

demo: $(READY)  ## a chart through a lens with aberrations, a zone plate without an OLPF and with one, into out/
	mkdir -p out
	$(BIN)/camsim capture e-sfr $(DAYLIGHT) --set "lens=$(ABERRATED)" --set "region={rows: 300, cols: 446}" \
	  --set scene.shapes.0.height=285 --set render.tolerance=1e-3 -o out/chart.dng -o out/chart.png -o out/chart.exr
	$(BIN)/camsim capture zone-plate $(DAYLIGHT) $(ZONES) --set sensor.olpf=null -o out/no-olpf.png
	$(BIN)/camsim capture zone-plate $(DAYLIGHT) $(ZONES) -o out/olpf.png

pictures: demo  ## the pictures of the README and of the site's first page, from the demo
	for name in chart no-olpf olpf; do cp out/$$name.png docs/demo-$$name.png; done

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

QUICK := architecture/test_layers analytic/test_spectra analytic/test_radiometry analytic/test_discs \
  properties/test_optical_stages analytic/test_oracle properties/test_electronic_stages analytic/test_sensor_stages \
  analytic/test_cfa analytic/test_adc config/test_capture files/test_formats measured/test_image_orientation \
  files/test_dng measured/test_colour measured/test_grey_card measured/test_mtf_series measured/test_photon_transfer \
  cli/test_capture_command cli/test_expose sweeping/test_studies

test-quick: $(READY)  ## every stage once, a minute
	$(BIN)/python -m pytest -q $(SIDE_BY_SIDE) $(QUICK:%=tests/%.py)

test-oldest:  ## the core of the tests with the oldest packages that pyproject.toml admits, in an environment of their own
	$(PYTHON) -m venv $(VENV)-oldest
	$(VENV)-oldest/bin/python bench/oldest.py > $(VENV)-oldest/oldest.txt
	$(VENV)-oldest/bin/python -m pip install --quiet --constraint $(VENV)-oldest/oldest.txt --editable . \
	  'pytest>=8.2' 'hypothesis>=6.100' 'mpmath>=1.4'
	$(VENV)-oldest/bin/python -m pytest -q -W default tests/files/test_formats.py \
	  tests/analytic/test_radiometry.py tests/analytic/test_adc.py tests/analytic/test_cfa.py tests/analytic/test_oracle.py

# What last bits can decide: sums of BLAS and of kernels against truths, files' bytes, figures of measured edges, colours
# and noise. Messages, layers, pages and laws of single stages are the same on every processor.
BY_PROCESSOR := analytic files cli/test_info_and_recapture.py measured/test_same_bytes.py measured/test_mtf.py \
  measured/test_colour.py measured/test_grey_card.py measured/test_photon_transfer.py measured/test_noise_truths.py

test-machines: $(READY)  ## forty captures, then what depends on a processor (TESTS=… for another part), as on six: the same codes and bytes
	$(BIN)/python -m bench.machines
	$(BIN)/python -m bench.machines tests -q $(SIDE_BY_SIDE) $(or $(TESTS),$(BY_PROCESSOR:%=tests/%))

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

attack: $(READY)  ## random systems against independent truths, ten minutes; SEED=… COUNT=… draws others (docs/testing.md)
	NUMBA_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m tests.attack --seconds 520 \
	  $(if $(SEED),--seed $(SEED)) $(if $(COUNT),--count $(COUNT))
	NUMBA_NUM_THREADS=1 $(BIN)/python -m tests.attack.captures --seconds 60 $(if $(SEED),--seed $(SEED))

attack-quick: $(READY)  ## a few dozen
	NUMBA_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m tests.attack --quick --seed 1 --count 60 --seconds 60
	NUMBA_NUM_THREADS=1 $(BIN)/python -m tests.attack.captures --seed 1 --count 40 --seconds 40

mutants: $(READY)  ## one line of camsim changed at a time: do the tests notice? (docs/testing.md; an hour or two, goes on where it was)
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
	rm -rf $(VENV) $(VENV)-oldest out dist build
