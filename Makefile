# Every target sets up .venv from requirements.lock by itself. PYTHON names another Python 3.11.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
LOCK_TOOL := uv==0.13.9

BIN := .venv/bin
PIP := $(BIN)/python -m pip --quiet --quiet --disable-pip-version-check --no-input

# $(call timed,COMMANDS): run them, then say how long they took; keep their exit code.
timed = @start=$$(date +%s); ($(1)); code=$$?; echo "make $@: $$(($$(date +%s) - start)) s"; exit $$code

.PHONY: help demo test test-slow check bench bounds soak lock

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' Makefile | expand -t 12

demo: .venv/installed ## a simulated swarm drives through a random arena and maps it; prints a table and the path of the map
	$(call timed,$(BIN)/ommatidia demo)

test: .venv/installed ## run all tests but the slow ones
	$(call timed,$(BIN)/python -m pytest -m "not slow")

test-slow: .venv/installed ## run the slow tests
	$(call timed,$(BIN)/python -m pytest -m slow)

check: .venv/installed ## lint, format, types, and who imports whom
	$(call timed,$(BIN)/ruff check --quiet --output-format concise && $(BIN)/ruff format --check --quiet && $(BIN)/mypy && $(BIN)/lint-imports --no-logo)

bench: .venv/installed ## measure milliseconds per stage and bytes per frame
	$(call timed,$(BIN)/python -m tests.bench)

bounds: .venv/installed ## measure every promised figure; fails where one is missed
	$(call timed,$(BIN)/python -m tests.bounds)

soak: .venv/installed ## drive the swarm through 25 random arenas (about an hour); prints a table; fails where a bound is missed
	$(call timed,$(BIN)/python -m tests.soak)

lock: ## pin all dependencies anew into requirements.lock
	@echo "locking with $(LOCK_TOOL)"
	@$(PYTHON) -m venv --clear .venv-lock
	@.venv-lock/bin/python -m pip --quiet --quiet --disable-pip-version-check install --only-binary :all: $(LOCK_TOOL)
	$(call timed,.venv-lock/bin/uv pip compile --quiet --upgrade --all-extras --generate-hashes --no-emit-index-url --no-build \
		--python-version 3.11 --custom-compile-command "make lock" --output-file requirements.lock pyproject.toml)
	@rm -rf .venv-lock

.venv/locked: requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' || { echo "Python 3.11 is needed: make PYTHON=/path/to/python3.11"; exit 2; }
	@echo "setting up .venv from requirements.lock, once (about a minute)"
	@$(PYTHON) -m venv --clear .venv
	@$(PIP) install --require-hashes --only-binary :all: --requirement requirements.lock
	@touch $@

.venv/installed: .venv/locked pyproject.toml
	@$(PIP) install --no-deps --no-build-isolation --editable .
	@touch $@
