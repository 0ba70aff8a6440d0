# make demo    set up what is missing, then simulate, publish, log and replay the 8-ball bearing
# make check   quick tests of every room, within about a minute
# make test    set up what is missing, then run the tests; one file: make test T=tests/test_x.py
# make test-environments   what needs slow or strange surroundings: empty caches, a busy processor, other Pythons
# make docs    the documentation as pages for a browser, in build/docs; works without a network
# make lint    style and formatting
# make bench   what everything costs in the user's hand on this machine, as a table in docs/speed.csv; a quarter of an hour
# make size    tokens, files and lines of our sources, words of the pages; all tuned numbers: python bench/size.py --constants
# make mutants the tests against products that are broken on purpose: which of fifty they notice; half an hour
# make torture what logs and nodes survive: kills, torn writes, full disks, hostile goals; ten minutes, docs/reliability.md
# make setup   only the set-up: .venv/ with ROS 2 Jazzy, compiled core, interface package in install/
# make wheel   a wheel with the core compiled for x86-64-v2, -v3 and -v4, in build/wheel
# make clean   remove everything the set-up made

SHELL := /bin/bash
# Byte code is kept whatever the shell says (images of containers often say no): it saves two thirds of a start.
unexport PYTHONDONTWRITEBYTECODE
PYTHON ?= python3
.DEFAULT_GOAL := help
.PHONY: help setup base wheel bench size mutants check test test-environments torture docs lint format demo clean missing
.NOTPARALLEL:

, := ,
STAMPS := .venv/stamps
STARTED := $(shell date +%s)
stage = @echo "== $$(( $$(date +%s) - $(STARTED) )) s: $(1)" >&2
LOGS := build/logs

# What building the interface package needs from the machine; a sentence when it is not there.
CXX_FOUND := $(shell for c in $(CXX) c++ g++ clang++; do command -v $$c && break; done)
HEADERS_FOUND := $(shell $(PYTHON) -c 'import os, sysconfig; print(*filter(os.path.exists, [sysconfig.get_path("include") + "/Python.h"]))' 2>/dev/null)
MISSING := $(if $(CXX_FOUND),$(if $(HEADERS_FOUND),,the headers of Python (Debian: apt install python3-dev)),a C++ compiler (Debian: apt install g++))
TESTS_MEGABYTES := 300
ifdef MISSING
  FLAVOUR := plain
  MEGABYTES := 550
  REQUIREMENTS := requirements/runtime.txt
else
  FLAVOUR := ros
  MEGABYTES := 800
  REQUIREMENTS := requirements/runtime.txt requirements/ros.txt requirements/build.txt
endif
PACKAGES := $(STAMPS)/packages-$(FLAVOUR)
TOOLS := $(STAMPS)/tools-$(FLAVOUR)
SIZE := about $(MEGABYTES) MB of disk, make setup $(TESTS_MEGABYTES) MB more
room = free=$$(df -Pm . | awk 'NR == 2 {print $$4}'); test "$$free" -gt $(1) || \
  { echo "Only $$free MB are free here and the set-up takes $(1) MB: make room, or move the checkout." >&2; exit 1; }
INTERFACES := $(if $(MISSING),missing,install/.interfaces)
CORE := $(if $(CXX_FOUND),$(STAMPS)/core)
INTERFACES_TOO := $(if $(MISSING),,install/.interfaces_cpp)

help:
	@sed -n 's/^# make/make/p' Makefile

base: $(PACKAGES) $(CORE) $(STAMPS)/package $(INTERFACES)

setup: $(INTERFACES_TOO) base $(TOOLS)

missing:
	@echo "The nodes are left out, because $(MISSING) is missing; command line, logs and pictures work without." >&2
	@test -z "$(CI)"

$(STAMPS)/venv:
	@$(PYTHON) -c 'import sys; sys.version_info >= (3, 10) or sys.exit("Python 3.10 or newer is needed and $(PYTHON) is %d.%d: use make PYTHON=/path/to/python3." % sys.version_info[:2])'
	$(call stage,virtual environment .venv with $(PYTHON): it will take $(SIZE)$(,) all of it below this folder)
	@$(call room,$(MEGABYTES))
	@.ci/stage $(LOGS)/venv.txt 5 "making .venv" $(PYTHON) -m venv .venv
	@.ci/stage $(LOGS)/pip.txt 5 "installing pip" .venv/bin/python -m pip install -r requirements/pip.txt
	@mkdir -p $(STAMPS) && touch $@

# One resolver call for everything: faster than one a file, and the pins are checked against each other. Python compiles what
# is imported, a tenth of what is installed: pip compiles it all.
PIP_INSTALL := .venv/bin/python -m pip install --no-compile
$(PACKAGES): $(STAMPS)/venv $(REQUIREMENTS)
	$(call stage,Python packages$(if $(MISSING),, and ROS 2 Jazzy)$(,) about 30 s)
	@.ci/stage $(LOGS)/packages.txt 30 "installing packages" $(PIP_INSTALL) $(addprefix -r ,$(REQUIREMENTS))
	@touch $@

$(TOOLS): $(PACKAGES) requirements/test.txt
	$(call stage,packages of tests and extras$(,) about 20 s)
	@$(call room,$(TESTS_MEGABYTES))
	@.ci/stage $(LOGS)/tools.txt 20 "installing packages of tests and extras" \
	  $(PIP_INSTALL) $(addprefix -r ,$(REQUIREMENTS) requirements/test.txt)
	@touch $@

# Also after an edit of its sources. A new stamp does not make the package anew, which refers to the library in place.
$(STAMPS)/core: $(STAMPS)/venv $(shell find core -name '*.[ch]pp' -o -name build.py)
	$(call stage,compiled core$(,) about 60 s)
	@.ci/stage $(LOGS)/core.txt 60 "compiling the core" .venv/bin/python core/build.py
	@touch $@

# One wheel for all processors from x86-64-v2 on.
wheel: base
	@BEARING_TWIN_MARCH=all .ci/stage $(LOGS)/wheel.txt 180 "building the wheel in build/wheel" \
	  .venv/bin/python -m pip wheel --no-deps --no-build-isolation --wheel-dir build/wheel .
	@ls build/wheel/*.whl

$(STAMPS)/package: $(PACKAGES) Makefile .ci/ament_index.py launch setup.py setup.cfg pyproject.toml package.xml | $(CORE)
	$(call stage,bearing_twin into .venv)
	@.ci/stage $(LOGS)/package.txt 5 "installing bearing_twin" \
	  .venv/bin/python -m pip install --no-deps --no-build-isolation --config-settings editable_mode=compat --editable .
	@.venv/bin/python .ci/ament_index.py .venv
	@touch $@

# $(1) seconds, $(2) further settings of CMake. tf2_msgs is built too where this ROS has none: its wheels lack the package.
define build_interfaces
	$(call stage,interface packages$(,) about $(1) s)
	@mkdir -p install && rm -f install/local_setup.bash && source env.bash && \
	  tf=$$(python -c 'import importlib.util as u; print("" if u.find_spec("tf2_msgs") else "tf2_msgs")') && \
	  .ci/stage $(LOGS)/interfaces.txt $(1) "building bearing_twin_msgs $$tf" \
	  colcon --log-level error build --base-paths msg_schemas $${tf:+cmake/$$tf} --packages-select bearing_twin_msgs $$tf \
	  --event-handlers console_direct+ console_cohesion- --cmake-clean-cache \
	  --cmake-args -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_TESTING=OFF -DCMAKE_INSTALL_MESSAGE=NEVER \
	  -DCMAKE_PROJECT_INCLUDE="$(CURDIR)/cmake/relocate.cmake" $(2) -Wno-dev
	@touch install/.interfaces $@
endef
SCHEMAS := $(PACKAGES) $(shell find cmake msg_schemas -type f)

# What our own nodes need, in half the time; where C++ has been built for, that is kept up to date too.
install/.interfaces: $(SCHEMAS)
	$(call build_interfaces,30,-DPYTHON_ONLY=$(if $(wildcard install/.interfaces_cpp),OFF,ON))

install/.interfaces_cpp: $(SCHEMAS)
	$(call build_interfaces,60,-DPYTHON_ONLY=OFF)

QUICK := architecture parameters scene kinds laws equilibrium channels log study cli
check: base $(TOOLS)
	$(call stage,quick tests of every room)
	@source env.bash && python -m pytest $(QUICK:%=tests/test_%.py)

# Files of tests go to two processes, each file whole, so that its tests share what its fixtures made; from both ends of
# our order, so that each process has to do with neighbours (`tests/conftest.py`).
SIDE_BY_SIDE := --numprocesses 2 --dist loadfile --no-loadscope-reorder

# With CI set no ROS test may be skipped: a missing ROS is then an error.
test: setup
	$(call stage,tests)
	@source env.bash && BEARING_TWIN_REQUIRE_ROS=$(if $(CI),1,$(BEARING_TWIN_REQUIRE_ROS)) python -m pytest $(or $(T),$(SIDE_BY_SIDE))

test-environments: setup $(STAMPS)/docs
	$(call stage,tests of environments)
	@source env.bash && BEARING_TWIN_REQUIRE_ROS=$(if $(CI),1,$(BEARING_TWIN_REQUIRE_ROS)) python -m pytest -m environment --timeout 3000 -o faulthandler_timeout=3300 -v $(T)

bench: setup
	@source env.bash && ROS_DOMAIN_ID=$${ROS_DOMAIN_ID:-87} python bench/table.py --write
	@.venv/bin/python bench/view.py
ifndef MISSING
	@source env.bash && ROS_DOMAIN_ID=$${ROS_DOMAIN_ID:-87} python bench/watch_cost.py
endif

# The standard library is enough, so that it counts before any set-up.
size:
	@$(PYTHON) bench/size.py

mutants: setup
	$(call stage,mutants$(,) about half an hour)
	@source env.bash && python tests/mutants.py

torture: setup
	$(call stage,torture$(,) ten minutes)
	@source env.bash && python tests/torture.py --write

$(STAMPS)/docs: $(PACKAGES) requirements/docs.txt
	@.ci/stage $(LOGS)/docs_packages.txt 15 "installing what builds the docs" .venv/bin/python -m pip install -r requirements/docs.txt
	@touch $@

docs: $(STAMPS)/package $(STAMPS)/docs
	@.ci/stage $(LOGS)/docs.txt 20 "building the docs" .venv/bin/python -m sphinx -W --keep-going -b html docs build/docs
	@echo "file://$(CURDIR)/build/docs/index.html"

# Another style: where the summary stands (D213), its mood (D401), symbols as first words (D402, D403), and NumPy's
# sections, which end without a blank line and name the parameters that need words (D413, D417).
LINTED := bearing_twin core launch tests bench docs setup.py .ci
ANOTHER_STYLE := D213 D401 D402 D403 D413 D417
lint: $(TOOLS)
	@.venv/bin/ruff check .
	@.venv/bin/ruff format --check .
	@git ls-files 'core/*.[ch]pp' | xargs .venv/bin/clang-format --dry-run --Werror
	@.ci/stage $(LOGS)/ament_flake8.txt 15 "ament_flake8" .venv/bin/ament_flake8 --config setup.cfg $(LINTED)
	@.ci/stage $(LOGS)/ament_pep257.txt 10 "ament_pep257" .venv/bin/ament_pep257 --add-ignore $(ANOTHER_STYLE) -- $(LINTED)
	@.venv/bin/reuse lint --quiet || { .venv/bin/reuse lint --lines; exit 1; }

format: $(TOOLS)
	@.venv/bin/ruff check --fix .
	@.venv/bin/ruff format .
	@git ls-files 'core/*.[ch]pp' | xargs .venv/bin/clang-format -i

demo: base
	$(call stage,demo)
ifdef MISSING
	@mkdir -p demo && run=$$(mktemp -d demo/$$(date +%Y%m%d_%H%M%S)_XXXXXX)/run && \
	  .venv/bin/bearing_twin simulate bearing_6203_load_and_speed --out $$run.mcap --plot $$run.png && \
	  .venv/bin/bearing_twin view $$run.mcap --out $$run.html
else
	@source env.bash && python -m bearing_twin.nodes.entry demo
endif

clean:
	rm -rf .venv build install log bearing_twin/_core bearing_twin.egg-info .pytest_cache .ruff_cache
	find . -name __pycache__ -not -path './.git/*' -prune -exec rm -rf {} +
