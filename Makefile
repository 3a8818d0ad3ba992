# Set up, run, check and measure the studio. Everything lands in .venv, build and bench-results.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip install --quiet
JOBS ?= 2
# an edit in one file does not empty numba's cache of another: checks start with none
CHECK_CACHE := build/numba-cache
# what one program has read of the sources, tests included, the next need not read again: each takes 10 s for it
CHECK := PYTHONDONTWRITEBYTECODE= QT_QPA_PLATFORM=offscreen NUMBA_CACHE_DIR=$(CURDIR)/$(CHECK_CACHE)

# tests of one file share what took long to build; in order, the files that take longest are not the last
BY_FILE := --dist loadfile --no-loadscope-reorder
LAST := command -v avr-g++ >/dev/null || echo "No avr-g++: what needs the firmware was not checked."
# what most tests need compiled: each part once, before two programs at a time would each do all of it
WARM := warm-verdict warm-boards warm-analysis

.PHONY: help run test test-all lint warm-loop $(WARM) bench pictures firmware board fuzz soak realtime clean
.DEFAULT_GOAL := help

help:
	@echo "make run       set up and open the studio"
	@echo "make test      set up and check everything"
	@echo "make test-all  the same, then what takes longer"
	@echo "make bench     measure, beside a reference each; draw the charts of the README anew"
	@echo "make pictures  take the pictures of README and docs anew"
	@echo "make fuzz      ten million inputs for firmware and decoders, some minutes"
	@echo "make soak      record for 40 minutes at 4 kHz while environments and views change: memory, missing rows"
	@echo "make firmware  build the board's program and the virtual board"
	@echo "make realtime  say what priority the loop obtains, and how to get more"
	@echo "make clean     remove everything built"

run: $(VENV)/.compiled
	@.ci/system-packages.sh run
	@$(BIN)/hapkit-studio

test: $(VENV)/.test
	@.ci/system-packages.sh test
	@rm -rf $(CHECK_CACHE)
	@$(MAKE) --no-print-directory -j$(JOBS) lint board $(WARM)
	$(CHECK) $(BIN)/python -m pytest -q -n $(JOBS) $(BY_FILE) -m "not alone and not slow"
	@$(LAST)

test-all: test
	$(CHECK) $(BIN)/python -m pytest -q -n $(JOBS) $(BY_FILE) -m "slow and not alone"
	$(CHECK) $(BIN)/python -m pytest -q -m alone $$(grep -rl "mark\.alone" tests --include="test_*.py")
	@$(LAST)

$(WARM): warm-loop
warm-loop $(WARM): warm-%: $(VENV)/.test
	@$(CHECK) XDG_CACHE_HOME=$(CURDIR)/build $(BIN)/python -m hapkit_studio.gui.state.prepare $*

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

# without the cross compiler a person may still check the rest; the build machine may not
board:
	@if command -v avr-g++ >/dev/null || [ -n "$$CI" ]; then $(MAKE) --no-print-directory -C firmware all; \
	else echo "No avr-g++: the firmware and what needs it are left out."; fi

fuzz: $(VENV)/.test
	@.ci/system-packages.sh fuzz
	$(BIN)/python -m tests.protocol.fuzz

soak: $(VENV)/.test
	@.ci/system-packages.sh run
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m tests.soak

realtime: $(VENV)/.run
	@$(BIN)/python -c "from hapkit_studio.haptics.priority import report; print(report())"

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

# the first start then is as quick as every later one; after an edit the window compiles by itself
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
