# Everything starts here: make run, make test, make test-slow, make check, make docs, make bench, make fuzz, make mutants.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ORDER ?= jsk_pick_sample
SEED ?= 1
PERCEPTION ?= noise
CASES ?= 20000
SIGHT ?= 1500
KERNEL_SOURCES := pickcli/kernel/CMakeLists.txt $(shell find pickcli/kernel/src -type f)

PEERS := .venv-peers
VENDOR := pickcli/page/vendor
LOCKER := .venv-lock
INSTALL_PEERS := $(PEERS)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps

.PHONY: run test test-slow check check-kernel check-wheel stubs docs coverage fuzz mutants bench bench-perception bench-peers install lock three format clean

# The lock is complete, so nothing is resolved: older pips look up what is asked for with an extra anew, past its pin.
install: $(VENV)/.installed

$(VENV)/.installed: requirements-dev.lock pyproject.toml CMakeLists.txt $(KERNEL_SOURCES)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--no-deps --require-hashes -r requirements-dev.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	touch $@

run: install
	$(BIN)/apc run-trial $(ORDER) --seed $(SEED) --perception $(PERCEPTION) --overwrite

# A worker per core; a file stays on one worker, so that what its tests share is made once. In the end the slowest are told.
PYTEST := $(BIN)/python -m pytest -n logical --no-loadscope-reorder --durations 40 --durations-min 3

test: install
	$(PYTEST) --dist loadfile -m "not slow"

# Whole trials, builds that are killed, piles judged by physics, every code block of the documentation.
test-slow: install
	$(PYTEST) --dist worksteal -m slow

check: install
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# The pages, in build/docs/index.html. A warning is an error.
docs: install
	$(BIN)/sphinx-build --jobs auto --fail-on-warning --keep-going --quiet docs build/docs

# The kernel's own suite under the address and undefined-behaviour sanitizers; CXX=clang++ builds it with clang.
check-kernel: install
	$(BIN)/cmake -S tests/kernel/native -B build/kernel-$(notdir $(firstword $(CXX))) -DCMAKE_CXX_COMPILER="$(firstword $(CXX))"
	$(BIN)/cmake --build build/kernel-$(notdir $(firstword $(CXX))) --parallel 2
	build/kernel-$(notdir $(firstword $(CXX)))/kernel_tests

# As a user installs it: a wheel in an environment of its own, without the lock and without the clone.
WHEEL := build/wheel
check-wheel:
	rm -rf $(WHEEL) && $(PYTHON) -m venv $(WHEEL)/venv
	$(WHEEL)/venv/bin/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir $(WHEEL) .
	$(WHEEL)/venv/bin/python -m pip install --quiet --disable-pip-version-check $(WHEEL)/*.whl
	cd $(WHEEL) && venv/bin/apc check apc2016_delft && venv/bin/apc plan-move --cell apc2016_delft --to bin_A -o move.json && \
		venv/bin/apc verify move.json --cell apc2016_delft

# The kernel's type stubs, from its docstrings and signatures.
stubs: install
	$(BIN)/python -m nanobind.stubgen -q -m pickcli.kernel._kernel -o pickcli/kernel/_kernel.pyi

coverage: install
	$(BIN)/python -m pytest -m "not slow" --cov=pickcli --cov-report=term-missing:skip-covered

fuzz: install
	$(BIN)/python -m bench.fuzz --cases $(CASES)

mutants: install
	$(BIN)/python -m bench.mutants

bench: install
	$(BIN)/python -m bench

# All that is asked of perception, measured on fresh seeds, in one table.
bench-perception: install
	$(BIN)/python -m bench.eyes --seed $(SIGHT)0

# The peers live in an environment of their own. One that does not install becomes a row that says so.
$(PEERS)/.installed: bench/peers/requirements.txt
	test -x $(PEERS)/bin/python || $(PYTHON) -m venv $(PEERS)
	$(INSTALL_PEERS) -r $< || grep -v '^#' $< | xargs -n 1 sh -c '$(INSTALL_PEERS) $$0 || true'
	touch $@

bench-peers: install $(PEERS)/.installed
	$(BIN)/python -m bench.peers

# Both files keep their versions as far as pyproject.toml allows; delete one to move to the newest of everything.
LOCK := $(LOCKER)/bin/uv pip compile pyproject.toml --quiet --generate-hashes --no-annotate \
	--custom-compile-command "make lock" --python-version 3.11 --python-platform x86_64-manylinux_2_28

lock: $(LOCKER)/bin/uv
	$(LOCK) --extra all --output-file requirements.lock
	$(LOCK) --extra dev --constraint requirements.lock --output-file requirements-dev.lock

$(LOCKER)/bin/uv:
	$(PYTHON) -m venv $(LOCKER)
	$(LOCKER)/bin/python -m pip install --quiet --disable-pip-version-check uv

# three.js for the pages, bundled anew from the pinned packages of the npm registry. Same pins, same bytes: a test
# compares their hash with the one in three.json.
three:
	rm -rf build/three && mkdir -p build/three && cp $(VENDOR)/package.json $(VENDOR)/package-lock.json $(VENDOR)/three_parts.js build/three/
	cd build/three && npm ci --silent --no-audit --no-fund && npm run --silent build
	cp build/three/three.min.js $(VENDOR)/three.min.js && cp build/three/node_modules/three/LICENSE $(VENDOR)/LICENSE
	sha256sum $(VENDOR)/three.min.js

format: install
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) $(PEERS) $(LOCKER) build .mypy_cache .ruff_cache .pytest_cache .import_linter_cache
