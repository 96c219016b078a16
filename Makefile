# Everything starts here: make run, make test, make check, make bench, make fuzz, make mutants.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ORDER ?= jsk_pick_sample
SEED ?= 1
CASES ?= 20000
KERNEL_SOURCES := $(wildcard pickcli/kernel/CMakeLists.txt pickcli/kernel/src/*)

PEERS := .venv-peers
INSTALL_PEERS := $(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps

.PHONY: run test check fuzz mutants bench bench-peers install format clean

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

fuzz: install
	$(BIN)/python -m bench.fuzz --cases $(CASES)

mutants: install
	$(BIN)/python -m bench.mutants

bench: install
	$(BIN)/python -m bench

# The peers live in an environment of their own. One that does not install becomes a row that says so.
$(PEERS)/.installed: bench/peers/requirements.txt
	test -x $(PEERS)/bin/python || $(PYTHON) -m venv $(PEERS)
	$(INSTALL_PEERS) -r $< || grep -v '^#' $< | xargs -n 1 sh -c '$(INSTALL_PEERS) $$0 || true'
	touch $@

bench-peers: install $(PEERS)/.installed
	$(BIN)/python -m bench.peers

format: install
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) $(PEERS) build .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
