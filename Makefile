# Each target sets up .venv by itself and reuses it until requirements.lock or pyproject.toml change.
# Needs git, make, python3 (3.11 or newer) and python3-venv; uses uv where it is installed, because it is faster.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
JOBS ?= 2
PYTEST := $(BIN)/python -m pytest
# by files: tests of one share fixtures and compiled kernels, which each process would make for itself otherwise; in their order, so that
# short doctests come last
SPREAD := -n $(JOBS) --dist loadfile --no-loadscope-reorder -q

# one thread per process: the work is spread over processes
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1
export MKL_NUM_THREADS := 1

.PHONY: help demo test test-interpreted lint format study viscoelastic recalibrate verify benchmark picture lock clean

help: ## list the targets
	@grep -E '^[a-z-]+: .*##' $(MAKEFILE_LIST) | sed -E 's/:[^#]*## /\t/' | expand -t 20

demo: $(READY) ## from a material to a DEM run: writes results/quickstart/report.html
	@echo "demo: fe2dem run cases/quickstart.toml"
	@$(BIN)/fe2dem run cases/quickstart.toml --out results/quickstart

test: $(READY) ## the test suite, compiled
	@echo "test: pytest on $(JOBS) processes, kernels compiled"
	@$(PYTEST) $(SPREAD)

test-interpreted: $(READY) ## the test suite with numba switched off, apart from the tests that say why not
	@echo "test-interpreted: pytest on $(JOBS) processes, kernels interpreted"
	@NUMBA_DISABLE_JIT=1 $(PYTEST) $(SPREAD)

lint: $(READY) ## ruff, mypy, and the direction of imports
	@echo "lint: ruff check"; $(BIN)/ruff check .
	@echo "lint: ruff format --check"; $(BIN)/ruff format --check .
	@echo "lint: mypy"; $(BIN)/mypy
	@echo "lint: import-linter"; $(BIN)/lint-imports

format: $(READY) ## let ruff lay out the sources
	@$(BIN)/ruff check --fix-only . && $(BIN)/ruff format .

study: $(READY) ## Edmans & Sinka 2020 done again: 560 unloadings and 280 of unseen materials, tables, figures, every statement judged
	@$(BIN)/fe2dem run cases/edmans_sinka_2020/study.toml --jobs $(JOBS) --out results/edmans_sinka_2020
	@$(BIN)/fe2dem run cases/edmans_sinka_2020/unseen.toml --jobs $(JOBS) --out results/unseen
	@$(BIN)/python -m cases.edmans_sinka_2020 results/edmans_sinka_2020 --unseen results/unseen --out results/study

viscoelastic: $(READY) ## Wahn, Gan & Kamlah 2022: two spheres with numbers, laws against finite elements, terms against cost; packings, bands over seeds; some 16 CPU minutes
	@$(BIN)/python -m cases.wahn_gan_kamlah_2022 --out results/wahn_gan_kamlah_2022
	@$(BIN)/python -m cases.wahn_gan_kamlah_2022 --packings --out results/wahn_gan_kamlah_2022

ellipsoids: $(READY) ## Becker & Kamlah 2021 done again with 369 spheroids: figures, constants of any material, every statement judged; some 45 CPU minutes
	@$(BIN)/python -m cases.becker_kamlah_2021 --jobs $(JOBS)

recalibrate: study ## what is shipped, made anew from curves: atlas, constants of the whole-range law, scores of all laws
	@$(BIN)/fe2dem run cases/edmans_sinka_2020/small.toml --jobs $(JOBS) --out results/small
	@$(BIN)/python -m calibration.atlas_build results/atlas results/edmans_sinka_2020/curves --compute --jobs $(JOBS)
	@$(BIN)/python -m calibration.whole_range_fit results/edmans_sinka_2020/curves results/atlas results/small/curves --unseen results/unseen/curves --evaluations 90
	@$(BIN)/python -m calibration.spheroid_curves results/becker_kamlah_2021/curves --jobs $(JOBS)
	@$(BIN)/python -m calibration.whole_range_shape_fit results/becker_kamlah_2021/curves
	@$(BIN)/fe2dem tournament results/edmans_sinka_2020 --out results/tournament
	@$(BIN)/fe2dem tradeoff law results/tournament --save-scores calibration/data/tradeoff_law.parquet

verify: $(READY) ## theory, convergence, tolerances, extremes, cycles, pairs, the atlas, particles; with FE2DEM_REFERENCE=FOLDER another code's curves
	@echo "verify: the continuum solver against theory and its own finer meshes; about 20 minutes on one core"
	@$(BIN)/python -m cases.verification.continuum
	@echo "verify: extreme bodies, partial cycles, unlike pairs, the atlas on other materials; about 20 minutes more"
	@$(BIN)/python -m cases.verification.extremes --jobs $(JOBS)
	@$(BIN)/python -m cases.verification.similarity
	@$(BIN)/python -m cases.verification.cycles
	@$(BIN)/python -m cases.verification.pairs
	@echo "verify: viscoelastic bodies and laws; about 5 minutes"
	@$(BIN)/python -m cases.verification.viscoelastic
	@$(BIN)/python -m cases.verification.viscoelastic_extremes
	@$(BIN)/python -m calibration.atlas_check results/atlas_check --compute --jobs $(JOBS)
	@echo "verify: particle simulations at the extremes; about 3 minutes"
	@$(BIN)/python -m cases.verification.dem_extremes --out results/dem_extremes
	@if [ -n "$$FE2DEM_REFERENCE" ]; then $(BIN)/python -m cases.verification.reference_curves; \
	else echo "verify: no comparison with another code: FE2DEM_REFERENCE names no folder of its curves"; fi

benchmark: $(READY) ## CPU seconds per curve, beside CalculiX where ccx is installed
	@$(BIN)/python -m cases.benchmarks

picture: $(READY) ## the README's picture, from the demo's results
	@$(BIN)/fe2dem run cases/quickstart.toml --out results/quickstart
	@$(BIN)/python -m cases.report.pictures results/quickstart docs/pictures

lock: ## pin all dependencies anew (needs uv)
	uv pip compile --universal --generate-hashes --python-version 3.11 --group dev --extra cluster --no-annotate --no-header --upgrade pyproject.toml -o requirements.lock

clean: ## remove .venv and all caches; results/ stays
	rm -rf $(VENV) .pytest_cache .mypy_cache .ruff_cache .hypothesis .benchmarks .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(READY): requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and f"set-up: Python 3.11 or newer is needed, $(PYTHON) is {sys.version.split()[0]}; try make PYTHON=python3.12")'
	@if command -v uv >/dev/null; then set -e; \
		echo "set-up: uv creates $(VENV)"; uv venv --quiet --allow-existing --python "$$(command -v $(PYTHON))" $(VENV); \
		echo "set-up: uv installs the packages pinned in requirements.lock"; uv pip install --quiet --compile-bytecode --python $(BIN)/python --require-hashes -r requirements.lock; \
		uv pip install --quiet --python $(BIN)/python --no-deps --no-build-isolation -e .; \
	else set -e; \
		echo "set-up: python3 -m venv creates $(VENV)"; $(PYTHON) -m venv $(VENV); \
		echo "set-up: pip installs the packages pinned in requirements.lock (a few minutes; uv would be faster)"; \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --only-binary :all: --require-hashes -r requirements.lock; \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .; \
	fi
	@touch $(READY); echo "set-up: $(VENV) is ready"
