# Everything starts here: make run, make test, make check, make bench.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ORDER ?= data/tasks/jsk_pick_sample.json
SEED ?= 1
KERNEL_SOURCES := $(wildcard pickcli/kernel/CMakeLists.txt pickcli/kernel/src/*)

.PHONY: run test check bench install format clean

install: $(VENV)/.installed

$(VENV)/.installed: requirements.lock pyproject.toml CMakeLists.txt $(KERNEL_SOURCES)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

run: install
	$(BIN)/apc run-trial $(ORDER) --seed $(SEED) --overwrite

test: install
	$(BIN)/python -m pytest

check: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: install
	$(BIN)/python -m bench

format: install
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) build .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
