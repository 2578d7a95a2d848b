VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
READY := $(VENV)/.ready
KERNEL := src/varishold/kernel/.built
SOURCES := $(wildcard native/*.c native/*.h) native/build.py

ROOM ?= all
N ?= 3
SEED ?= 0

.PHONY: demo test laws check docs bench fuzz sanitize agree kills floors wheels dist mutants parameters format clean

demo: $(KERNEL)
	@mkdir -p out
	$(BIN)/varishold touch examples/surfaces.npz --frames press --report out/report.html
	$(BIN)/varishold perceive hexagonal-prism --size-m 0.05 --seed 5 --report out/perceive.html

# QUICK=1: without the tests that take long. Each process takes neighbours, so that what they share is made once.
test: $(KERNEL)
	$(BIN)/python -m pytest -n auto --dist worksteal $(if $(QUICK),--quick)

# The tests again on newly drawn examples.
laws: $(KERNEL)
	$(BIN)/python -m pytest -n auto --dist worksteal --hypothesis-profile=fresh

check: $(KERNEL)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The site, in out/site; GALLERY=0 leaves the examples unrun.
GALLERY ?= 1

docs: $(KERNEL)
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	$(BIN)/python -m docs.fill_tables
	MPLBACKEND=Agg $(BIN)/python -m sphinx -W --keep-going -q -D plot_gallery=$(GALLERY) -b html docs out/site
	$(BIN)/python docs/check_site.py out/site

# Beside what was printed last on such a machine; QUICK=1: what takes two minutes together, RECORD=1: kept from now on.
bench: $(KERNEL)
	$(BIN)/python -m benchmarks --compare $(if $(QUICK),--quick) $(if $(RECORD),--record)

FLOORS := .venv-floors

fuzz: $(KERNEL)
	$(BIN)/python -m hostile.fuzz --seed $(SEED)

# Both end where the kernel leaves an array, or does what has no meaning in C.
SANITIZED := -std=c99 -g -O1 -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -Inative
FRAMES ?= 20000

sanitize: $(KERNEL)
	@mkdir -p out
	$(CC) $(SANITIZED) hostile/kernel_fuzz.c native/*.c -o out/kernel_fuzz -lm
	out/kernel_fuzz $(FRAMES) $(SEED)
	$(CC) $(SANITIZED) -shared -fPIC -DVH_SHARED native/*.c -o out/kernel_sanitized.so -lm
	VARISHOLD_KERNEL=$(CURDIR)/out/kernel_sanitized.so LD_PRELOAD=$$($(CC) -print-file-name=libasan.so) \
	ASAN_OPTIONS=detect_leaks=0 $(BIN)/python -m pytest tests/test_levelset*.py tests/test_frame*.py \
	tests/test_kernel.py tests/test_touch*.py tests/test_grasp*.py tests/test_circuit_packed.py

# Random frames by the kernel and by the plain reference.
agree: $(KERNEL)
	$(BIN)/python -m hostile.sections --number $(FRAMES) --seed $(SEED)

kills: $(KERNEL)
	$(BIN)/python -m hostile.kills --seed $(SEED)
	$(BIN)/python -m hostile.recorder_kills --seed $(SEED)

floors:
	$(PYTHON) -m hostile.floors --python $(PYTHON) --venv $(FLOORS)

# A wheel for each platform, or those of PLATFORMS, compiled by a compiler from pip; run here as far as they can be.
WHEELS := .venv-wheels
PLATFORMS ?=

wheels:
	$(PYTHON) -m venv $(WHEELS)
	$(WHEELS)/bin/python -m pip install --quiet 'hatchling>=1.26' ziglang
	rm -rf out/wheels
	$(WHEELS)/bin/python -m native.wheels $(PLATFORMS)
	$(WHEELS)/bin/python -m hostile.wheels out/wheels/*.whl

# What would be released, installed into empty environments and tried there; TAG is checked where it is given.
DIST := .venv-dist
TAG ?=

dist:
	$(PYTHON) -m venv $(DIST)
	$(DIST)/bin/python -m pip install --quiet build
	$(DIST)/bin/python -m hostile.dist $(if $(TAG),--tag $(TAG))

mutants: $(KERNEL)
	$(BIN)/python -m mutants --room $(ROOM) --number $(N) --seed $(SEED)

parameters: $(KERNEL)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m training.surfaces
	$(BIN)/python -m training.pad_surfaces
	$(BIN)/python -m training.objects
	$(BIN)/python -m training.lying
	$(BIN)/python -m training.pad_touches

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
	rm -rf $(VENV) $(FLOORS) $(WHEELS) $(DIST) build out $(KERNEL) src/varishold/kernel/varishold_*
