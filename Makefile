# LARICS camera: every target sets up the .venv it needs by itself.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
export PYTHONPATH := shared:host
# so that `python` in MICROPYTHON is the one that has the tools
export PATH := $(CURDIR)/$(BIN):$(PATH)
# real MicroPython interpreter for the dual tests; any other build or a board's runner may be given
MICROPYTHON ?= $(BIN)/micropython
export MICROPYTHON

.PHONY: wheel docs vehicle-package help demo test coverage lint bench mpy flash reproduce fuzz vehicle clean setup
help:  ## this list
	@awk -F':.*## ' '/^[a-z]+:.*## /{printf "  make %-10s %s\n", $$1, $$2}' Makefile

setup: $(READY)  ## the .venv with pinned requirements (other targets do it when needed)
$(READY): requirements.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || \
		{ echo "make: the pinned tools need Python 3.11 or newer, $(PYTHON) is not: set PYTHON=/path/to/it"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -r requirements.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps -e .
	@touch $(READY)

demo: $(READY)  ## a rendered drive through the firmware on MicroPython: table and picture
	$(BIN)/python -m tools.demo $(DEMO)

test: $(READY)  ## all tests on all cores: host, both interpreters, C parser (TEST="-k flash" for some)
	$(BIN)/ruff check .
	$(BIN)/python -m pytest -n auto --dist worksteal -rs --durations=10 $(TEST)

coverage: $(READY)  ## the tests with their coverage, which takes half as long again
	$(BIN)/python -m pytest -n auto --dist worksteal --cov --cov-report= $(TEST)
	@echo "coverage of what ran in the tests' own processes: $$($(BIN)/coverage report --format=total) % of the lines"

lint: $(READY)  ## style, format, import rules, types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python tools/check_rules.py
	$(BIN)/mypy

bench: $(READY)  ## quality, stresses, time and instructions beside the peers (FRAMES=2000 for figures)
	$(BIN)/python tools/bench.py --frames $(or $(FRAMES),100) $(BENCH)

reproduce: $(READY)  ## the published experiment in closed loop: tables, figures and beyond (a quarter of an hour)
	PYTHONPATH=shared:host:. $(BIN)/python tools/reproduce.py $(REPRODUCE)

mpy: $(READY)  ## compile shared/ and firmware/ for the boards and report sizes
	$(BIN)/python tools/build_mpy.py

fuzz: $(READY)  ## long damage runs on both decoders of the wire (about fifteen minutes)
	$(BIN)/python tools/fuzz_wire.py $(FUZZ)

vehicle: $(READY)  ## the vehicle's C library on AVR, Cortex-M, big-endian: same results, flash, RAM, cycles
	$(BIN)/python tools/vehicle_targets.py

vehicle-package: $(READY)  ## archive of the vehicle's C library for Arduino, PlatformIO, CMake, ESP-IDF, Zephyr
	$(BIN)/python tools/vehicle_package.py $(if $(URL),--url '$(URL)')

wheel: $(READY)  ## the package for pip, firmware included, in build/wheel
	rm -rf build/wheel build/lib build/bdist*
	$(BIN)/pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation -w build/wheel .
	@cd build/wheel && sha256sum *.whl

docs: $(READY)  ## the site of these pages and docstrings, in build/docs (LINKS=1: addresses elsewhere, too)
	$(BIN)/python -m sphinx -W --keep-going -q -E -b html docs build/docs
	$(if $(LINKS),$(BIN)/python -m sphinx -q -b linkcheck docs build/links)
	@echo "open build/docs/index.html"

flash: $(READY)  ## put the firmware on the connected board (FLASH="--port /dev/ttyACM0 --dry-run")
	$(BIN)/larics flash $(FLASH)

clean:  ## remove what was built (the .venv stays)
	rm -rf build .coverage .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -not -path './.venv/*' -prune -exec rm -rf {} +
