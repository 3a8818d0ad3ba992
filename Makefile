# Set up, run, check and measure the studio. All output is written to .venv, build and bench-results.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip install --quiet
JOBS ?= 2
# the quick tests often wait, for threads and programs: with one worker more than processors they take 15 % less
WORKERS ?= 3
BUNDLE_PYTHON := build/bundle-venv/bin/python
# numba's cache does not detect edits in other files, so checks start with an empty one
CHECK_CACHE := build/numba-cache
# byte code is written, so that later processes do not compile sources and tests again, which takes 10 s each
CHECK := PYTHONDONTWRITEBYTECODE= QT_QPA_PLATFORM=offscreen NUMBA_CACHE_DIR=$(CURDIR)/$(CHECK_CACHE)

# tests of a file share slow fixtures; the order ensures that the slowest files are not the last
BY_FILE := --dist loadfile --no-loadscope-reorder
LAST := command -v avr-g++ >/dev/null || echo "No avr-g++: tests that need the firmware were skipped."
# compile the parts needed by most tests once, before two processes would both compile all of them
WARM := warm-verdict warm-boards warm-analysis

.PHONY: help run test test-all collect lint warm-loop $(WARM) bench pictures firmware board fuzz soak realtime bundle wheelhouse \
	acceptance clean
.DEFAULT_GOAL := help

help:
	@echo "make run       set up and open the studio"
	@echo "make test      set up and check everything"
	@echo "make test-all  the same, then the slow tests"
	@echo "make bench     run the benchmarks, each with a reference; redraw the charts of the README"
	@echo "make pictures  redraw the pictures of README and docs"
	@echo "make fuzz      test firmware and decoders with ten million inputs, some minutes"
	@echo "make soak      record for 40 minutes at 4 kHz while environments and views change: memory, missing rows"
	@echo "make firmware  build the board's firmware and the virtual board"
	@echo "make bundle    build a folder with Python, Qt and the studio, for computers without them: build/bundle"
	@echo "make wheelhouse  gather the wheels for an installation without a network: build/wheelhouse"
	@echo "make acceptance  build both and show them on this machine, and in the bare systems ROOTS=\"DIR ...\""
	@echo "make realtime  print the priority that the loop obtains, and how to get a higher one"
	@echo "make clean     remove everything built"

run: $(VENV)/.compiled
	@.ci/system-packages.sh run
	@$(BIN)/hapkit-studio

test: $(VENV)/.test
	@.ci/system-packages.sh test
	@rm -rf $(CHECK_CACHE)
	@$(MAKE) --no-print-directory -j$(JOBS) lint board collect $(WARM)
	$(CHECK) $(BIN)/python -m pytest -q -n $(WORKERS) $(BY_FILE) -m "not alone and not slow"
	@$(LAST)

test-all: test
	$(CHECK) $(BIN)/python -m pytest -q -n $(JOBS) $(BY_FILE) -m "slow and not alone"
	$(CHECK) $(BIN)/python -m pytest -q -m alone $$(grep -rl "mark\.alone" tests --include="test_*.py")
	@$(LAST)

$(WARM): warm-loop
warm-loop $(WARM): warm-%: $(VENV)/.test
	@$(CHECK) XDG_CACHE_HOME=$(CURDIR)/build $(BIN)/python -m hapkit_studio.gui.state.prepare $*

# pytest compiles the tests on first reading: once here, instead of in every worker
collect: $(VENV)/.test
	@$(CHECK) $(BIN)/python -m pytest -qq --collect-only >/dev/null

lint: $(VENV)/.test
	@.ci/system-packages.sh test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(VENV)/.bench
	@.ci/system-packages.sh bench
	@$(MAKE) --no-print-directory board
	$(BIN)/python -m tests.bench --pictures assets/pictures

pictures: $(VENV)/.run
	@.ci/system-packages.sh run
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m hapkit_studio.gui.shell.portraits assets/pictures
	$(BIN)/hapkit-studio environments --markdown > assets/docs/environments.md

firmware:
	@.ci/system-packages.sh firmware
	$(MAKE) --no-print-directory -C firmware all

# users without the cross compiler can check the rest; the build machine must have it
board:
	@if command -v avr-g++ >/dev/null || [ -n "$$CI" ]; then $(MAKE) --no-print-directory -C firmware all; \
	else echo "No avr-g++: the firmware and its tests are skipped."; fi

fuzz: $(VENV)/.test
	@.ci/system-packages.sh fuzz
	$(BIN)/python -m tests.protocol.fuzz

soak: $(VENV)/.test
	@.ci/system-packages.sh run
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m tests.soak

realtime: $(VENV)/.run
	@$(BIN)/python -c "from hapkit_studio.haptics.priority import report; print(report())"

# an environment of its own: what is installed there is what the bundle contains
bundle: $(BUNDLE_PYTHON)
	@$(BUNDLE_PYTHON) -m pip install --quiet --disable-pip-version-check ".[bundle]"
	@$(BUNDLE_PYTHON) -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall .
	@$(BUNDLE_PYTHON) .ci/bundle/build.py

$(BUNDLE_PYTHON):
	@.ci/system-packages.sh venv $(PYTHON)
	$(PYTHON) -m venv build/bundle-venv

# pipx brings its own pip up to date from the same folder
wheelhouse:
	@mkdir -p build/wheelhouse
	@rm -f build/wheelhouse/hapkit_studio-*
	@$(PYTHON) -m pip wheel --quiet --disable-pip-version-check --prefer-binary --wheel-dir build/wheelhouse . pip
	@echo "build/wheelhouse: $$(du -sm build/wheelhouse | cut -f1) MB. Install on a computer without a network by"
	@echo "    pipx install --pip-args='--no-index --find-links build/wheelhouse' hapkit-studio"

# wheels for every supported Python that starts on this computer
PYTHONS = $(foreach minor,11 12 13 14,$(shell python3.$(minor) -c "print('python3.$(minor)')" 2>/dev/null))
acceptance: bundle
	@for python in $(or $(PYTHONS),$(PYTHON)); do $(MAKE) --no-print-directory wheelhouse PYTHON=$$python || exit 1; done
	@$(PYTHON) tests/acceptance.py $(ROOTS)

clean:
	@$(MAKE) --no-print-directory -C firmware clean
	rm -rf build dist bench-results .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find hapkit_studio tests -name __pycache__ -type d -prune -exec rm -rf {} +

$(BIN)/pip:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed: make PYTHON=...")'
	@.ci/system-packages.sh venv $(PYTHON)
	$(PYTHON) -m venv $(VENV)

$(VENV)/.run: pyproject.toml | $(BIN)/pip
	@echo "Installing the studio into $(VENV) ..."
	@$(PIP) --editable .
	@touch $@

# compile in advance, so that the first start is as fast as later ones; after an edit the window compiles
$(VENV)/.compiled: $(VENV)/.run
	@$(BIN)/python -m compileall -q hapkit_studio
	@$(BIN)/python -m hapkit_studio.gui.state.prepare all
	@touch $@

# --no-compile: Python compiles only what the checks import
$(VENV)/.test: pyproject.toml | $(BIN)/pip
	@echo "Installing the studio and its checks into $(VENV) ..."
	@$(PIP) --no-compile --editable ".[test]"
	@touch $@ $(VENV)/.run

$(VENV)/.bench: pyproject.toml | $(BIN)/pip
	@echo "Installing the studio and its benchmarks into $(VENV) ..."
	@$(PIP) --editable ".[test,bench]"
	@touch $@ $(VENV)/.test $(VENV)/.run
