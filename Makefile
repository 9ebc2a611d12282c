# Everything runs in .venv, on ROS 2 from PyPI wheels; tools/setup.sh makes it and is done at once when nothing changed.
# PYTHON=/path/to/python makes it with another Python than the distribution's.

# A ROS 2 sourced in this shell must not mix with the wheels.
unexport PYTHONPATH PYTHONHOME CMAKE_PREFIX_PATH COLCON_PREFIX_PATH _ROS_WHEELS_BOOTSTRAP_COMPLETE
ifdef AMENT_PREFIX_PATH
unexport LD_LIBRARY_PATH
endif
export AMENT_PREFIX_PATH := $(CURDIR)/.venv
export RMW_IMPLEMENTATION := rmw_fastrtps_cpp
# Nodes of other people on the network stay out of tests and demonstration.
export ROS_AUTOMATIC_DISCOVERY_RANGE := LOCALHOST

# Tests run in three processes more than there are cores; PYTEST_ARGS="-n 0" runs them in one.
IN_PROCESSES := -n logical --maxprocesses 6
PYTEST := -m pytest $(IN_PROCESSES)

.PHONY: help setup demo test test-oldest lint paper bench verify colcon clean

help:  ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1 # /p' $(MAKEFILE_LIST) | awk -F' # ' '{printf "make %-11s %s\n", $$1, $$2}'

setup:  ## make .venv: ROS 2 wheels, the interface package, cpr_ros
	@bash tools/setup.sh

demo: setup  ## start the node, call its services, show the result
	@.venv/bin/cpr_demo

test: setup  ## run every test (PYTEST_ARGS="-m 'not slow'" to choose)
	@.venv/bin/python $(PYTEST) $(PYTEST_ARGS)

test-oldest: export AMENT_PREFIX_PATH := $(CURDIR)/.venv-oldest
test-oldest:  ## run every test with the numpy, scipy, numba and matplotlib of Ubuntu 24.04 (Python 3.11)
	@bash tools/setup.sh oldest
	@.venv-oldest/bin/python $(PYTEST) $(PYTEST_ARGS)

lint: setup  ## check style, formatting and types
	.venv/bin/ruff check
	.venv/bin/ruff format --check
	.venv/bin/mypy cpr_core cpr_ros paper benchmarks verification

paper: setup  ## compute the tables and figures of the paper (QUICK=1: coarser; PUBLISH=1: also into docs/paper)
	@.venv/bin/python -m paper $(if $(QUICK),--quick) $(if $(PUBLISH),--publish docs/paper)

bench: setup  ## measure how fast everything is (QUICK=1: less; BASELINE=file.json: compared with an earlier run)
	@.venv/bin/python -m benchmarks $(if $(QUICK),--quick) $(if $(BASELINE),--baseline $(BASELINE))

verify:  ## compare with other people's programs, installed for it, and published numbers (PUBLISH=1: also into docs/verification.md)
	@bash tools/setup.sh verify
	@.venv/bin/python -m verification $(if $(PUBLISH),--publish docs/verification.md)

colcon:  ## build and test with colcon, as in an ordinary ROS 2 workspace
	@bash tools/colcon.sh $(IN_PROCESSES) $(PYTEST_ARGS)

clean:  ## remove everything that was made
	rm -rf .venv .venv-oldest .venv-colcon build install log dist paper/results verification/results *.egg-info .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
