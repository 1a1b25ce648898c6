# `make run` and `make test` need only git, make and python3 (3.11 or newer).
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: run test test-slow lint kernels lab docs svg clean

# Installed anew when what is to be installed has changed.
$(VENV)/.installed: pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
	  || { echo "python3 is older than 3.11: make PYTHON=python3.12 ..."; exit 1; }
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@echo "Installing into $(VENV): some 900 MB, once; it takes a few minutes."
	$(BIN)/python -m pip install --disable-pip-version-check \
	  --constraint constraints.txt --editable '.[test,notebooks]'
	touch $@

run: $(VENV)/.installed
	$(BIN)/scara-drake run teleoperation --set operator.device=auto \
	  --record runs/teleoperation.nc --html runs/teleoperation.html

# A worker keeps the tests of a file together, which share what they simulate, until it has none.
test: $(VENV)/.installed
	$(MAKE) --jobs=2 lint kernels
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not slow"

# What only the slow tests compare with: other programs that read the URDF.
$(VENV)/.benchmarks: $(VENV)/.installed
	$(BIN)/python -m pip install --disable-pip-version-check \
	  --constraint constraints.txt --editable '.[benchmarks]'
	touch $@

# Ten times the examples of the property tests, and the long studies.
test-slow: $(VENV)/.benchmarks kernels
	SCARA_DRAKE_NIGHTLY=1 $(BIN)/python -m pytest -n 2 --dist worksteal --timeout=3000 \
	  -m "slow or hypothesis"

# Compiled once before several processes need them.
kernels: $(VENV)/.installed
	$(BIN)/python tests/compile_kernels.py

lint: $(VENV)/.installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

lab: $(VENV)/.installed
	$(BIN)/jupyter lab notebooks

# The site, in build/site/index.html, with the notebooks as they ran.
docs: $(VENV)/.installed kernels
	$(BIN)/python docs/run_notebooks.py
	$(BIN)/python docs/make_site.py

# The block diagrams beside the scenarios, drawn from the Diagrams (needs Graphviz).
svg: $(VENV)/.installed
	$(BIN)/scara-drake diagrams --render diagrams

clean:
	rm -rf $(VENV) build runs .pytest_cache .mypy_cache .ruff_cache
