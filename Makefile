VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
READY := $(VENV)/.ready
KERNEL := src/varishold/kernel/.built
SOURCES := $(wildcard native/*.c native/*.h) native/build.py

ROOM ?= all
N ?= 3
SEED ?= 0

.PHONY: demo test check bench fuzz kills floors mutants parameters format clean

demo: $(KERNEL)
	@mkdir -p out
	$(BIN)/varishold touch examples/surfaces.npz --frames press --report out/report.html
	$(BIN)/varishold perceive hexagonal-prism --size-m 0.05 --seed 5 --report out/perceive.html

test: $(KERNEL)
	$(BIN)/python -m pytest -n auto

check: $(KERNEL)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(KERNEL)
	$(BIN)/python -m benchmarks

FLOORS := .venv-floors

fuzz: $(KERNEL)
	$(BIN)/python -m hostile.fuzz --seed $(SEED)

kills: $(KERNEL)
	$(BIN)/python -m hostile.kills --seed $(SEED)

floors:
	$(PYTHON) -m hostile.floors --python $(PYTHON) --venv $(FLOORS)

mutants: $(KERNEL)
	$(BIN)/python -m mutants --room $(ROOM) --number $(N) --seed $(SEED)

parameters: $(KERNEL)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m training.surfaces
	$(BIN)/python -m training.pad_surfaces
	$(BIN)/python -m training.objects

format: $(KERNEL)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# Compiled when it is installed, and again when a C source has changed.
$(KERNEL): $(READY) $(SOURCES)
	$(BIN)/python native/build.py
	touch $@

$(READY): pyproject.toml hatch_build.py
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "varishold needs Python 3.11 or newer, got " + sys.version.split()[0])'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet -e '.[dev,all]'
	touch $(READY)

clean:
	rm -rf $(VENV) $(FLOORS) out $(KERNEL) src/varishold/kernel/varishold_*
