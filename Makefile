# make run   installs what is missing and runs the main job on the shipped rig
# make test  installs what is missing and runs the default tests
# make docs  installs what is missing and builds the site into build/site
# make test-lowest  runs them with the lowest versions that pyproject.toml allows, on the lowest Python
VENV ?= .venv
PYTHON ?= python3
BIN := $(VENV)/bin
LOWEST := .venv-lowest
LOWEST_PYTHON ?= python3.11
SYSTEM_PACKAGES := python3 python3-venv libglu1-mesa libgl1 libegl1 libosmesa6 libxcursor1 libxft2 libxinerama1 \
	libgomp1 libfontconfig1 libxrender1

.PHONY: run test test-lowest test-all lint docs bench peers system clean

run: $(BIN)/.installed
	$(BIN)/gearcase run rig-missing-tooth

test: $(BIN)/.installed-dev
	$(BIN)/python -m pytest -n 2 --dist worksteal

test-lowest: $(LOWEST)/.installed
	$(LOWEST)/bin/python -m pytest -n 2 --dist worksteal

test-all: $(BIN)/.installed-dev
	$(BIN)/python tests/all_parts.py

lint: $(BIN)/.installed-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: $(BIN)/.installed-docs
	MPLBACKEND=agg $(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --fresh-env --write-all -b html -d build/doctrees docs build/site
	@echo "open build/site/index.html"

bench: $(BIN)/.installed-dev
	$(BIN)/python -m benchmarks

# Programs to compare with, in an environment of their own; CalculiX is a Debian package (calculix-ccx).
peers: .peers/.installed

.peers/.installed: benchmarks/peers/requirements.txt | system
	$(PYTHON) -m venv .peers
	.peers/bin/python -m pip install --quiet --disable-pip-version-check --requirement benchmarks/peers/requirements.txt
	touch $@

# Installs the Debian packages that are missing: as root by itself, otherwise it prints the one line to type.
system:
	@if ! command -v dpkg-query >/dev/null; then \
		echo "Not a Debian system: make sure that Python 3.11 to 3.13 with venv and OpenGL (EGL or OSMesa) are installed."; \
	else \
		missing=""; \
		for package in $(SYSTEM_PACKAGES); do \
			dpkg-query -W -f '$${db:Status-Status}' $$package 2>/dev/null | grep -qx installed \
				|| { case $$package in \
					python3*) $(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || missing="$$missing $$package";; \
					libosmesa6) apt-cache show libosmesa6 >/dev/null 2>&1 && missing="$$missing $$package";; \
					*) missing="$$missing $$package";; \
				esac; }; \
		done; \
		if [ -n "$$missing" ]; then \
			if [ "$$(id -u)" = 0 ]; then \
				apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $$missing; \
			else \
				echo "Type this once, then repeat the command:"; \
				echo "  sudo apt-get install -y --no-install-recommends$$missing"; \
				exit 1; \
			fi; \
		fi; \
	fi

$(BIN)/python: | system
	$(PYTHON) -m venv $(VENV)

$(BIN)/.installed: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	touch $@

$(BIN)/.installed-dev: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $(BIN)/.installed $@

$(BIN)/.installed-docs: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@

$(LOWEST)/.installed: pyproject.toml tests/lowest_versions.py | system
	$(LOWEST_PYTHON) -m venv --clear $(LOWEST)
	$(LOWEST)/bin/python tests/lowest_versions.py > $(LOWEST)/lowest.txt
	$(LOWEST)/bin/python -m pip install --quiet --disable-pip-version-check --constraint $(LOWEST)/lowest.txt --editable '.[dev]'
	touch $@

clean:
	rm -rf $(VENV) $(LOWEST) build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache
