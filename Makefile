# make demo: everything from a fresh clone to pictures in output/. make test, make robustness (killed and random runs, tutorials), make lint
# (style, types, texts), make processors, make lowest, make wheel: what CI runs. make torch: the bridge to PyTorch. make docs: web pages in site/.
PYTHON ?= python3
VENV := .venv
INSTALLED := $(VENV)/.installed
DOCUMENTED := $(VENV)/.documented
BIN := $(VENV)/bin
MODEL := models/morphing_wing
SCENE := $(MODEL)_large/scene.toml
ROOMS = $(notdir $(patsubst %/__init__.py,%,$(wildcard tests/*/__init__.py)))
# Two workers on two cores: threads of the linear algebra would only wait for each other.
# A worker that crashes ends the run and names its test; with another one in its place some runs never end.
ALONE := OPENBLAS_NUM_THREADS=1
# gmsh lives on these (Debian, Ubuntu); nothing else needs them.
LIBRARIES := libglu1-mesa libgl1 libxcursor1 libxft2 libxinerama1 libgomp1

# Tests start hundreds of commands; where no bytecode is kept each of them compiles the project's text anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test fast robustness torch lint processors lowest wheel docs libraries
.DEFAULT_GOAL := demo

demo: $(INSTALLED) libraries
	@if $(BIN)/python -c 'import gmsh' 2>/dev/null; then echo ffrf-preprocess $(MODEL)/skin.toml; $(BIN)/ffrf-preprocess $(MODEL)/skin.toml; \
	else echo "gmsh lacks its system libraries: no meshing, going on with the reduced model that comes with the project."; fi
	$(BIN)/ffrf statics $(SCENE)
	$(BIN)/ffrf simulate $(SCENE)
	$(BIN)/ffrf sensitivity $(SCENE)
	$(BIN)/ffrf render $(SCENE) --output output

# A worker that crashes ends the run and names its test: with another one in its place a run may never end.
ifdef ROOM
test: $(INSTALLED)
	@test -d tests/$(ROOM) || { echo "There is no room $(ROOM). There are:" $(ROOMS); exit 1; }
	$(ALONE) $(BIN)/python -m pytest -q -m 'not robustness' tests/$(ROOM)
else
test: $(INSTALLED)
	$(ALONE) $(BIN)/python -m pytest -n 2 --max-worker-restart 0 --dist loadfile --no-loadscope-reorder --ignore=tests/repository -m 'not robustness'
endif

fast: $(INSTALLED)
	$(ALONE) $(BIN)/python -m pytest -q -m fast $(if $(ROOM),tests/$(ROOM),tests)

robustness: $(INSTALLED)
	$(ALONE) $(BIN)/python -m pytest -n 2 --max-worker-restart 0 --ignore=tests/repository -m robustness

# PyTorch's wheel for Linux brings gigabytes of CUDA's libraries unless PyTorch is there already, or pip is told of one without (TORCH).
TORCH ?= -e '.[torch]'
torch: $(INSTALLED)
	$(BIN)/python -m pip install --quiet $(TORCH)
	$(ALONE) $(BIN)/python -m pytest -q tests/bridges/test_bridges.py -k torch

lint: $(INSTALLED)
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python -m pytest -q tests/repository

processors: $(INSTALLED)
	.ci/processors

lowest: $(INSTALLED)
	.ci/lowest-versions $(BIN)

wheel: $(INSTALLED)
	.ci/wheel $(BIN)

docs: $(DOCUMENTED)
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --strict
	@echo site/index.html

$(DOCUMENTED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet -e '.[docs]'
	@touch $@

$(INSTALLED): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
		|| { echo "Python 3.11 or newer is needed, $(PYTHON) is not. Try: make $(MAKECMDGOALS) PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null \
		|| { echo "$(PYTHON) cannot make an environment: on Debian and Ubuntu run: apt-get install python3-venv"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -e '.[all]'
	@touch $@

libraries:
	@.ci/system-libraries $(LIBRARIES)
