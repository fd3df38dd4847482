# Every target sets up what it needs: a virtual environment in .venv with the pinned dependencies of constraints.txt.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := PIP_CONSTRAINT=constraints.txt PIP_DISABLE_PIP_VERSION_CHECK=1 $(BIN)/python -m pip install --quiet
OUT ?= results
COUNT ?= 10000
SEED ?= 1000000
WORKERS ?= auto
DRAW ?= $(shell git rev-parse --short HEAD 2>/dev/null || date +%F)
PAGES := README.md ARCHITECTURE.md CONTRIBUTING.md CHANGELOG.md docs
TEXTS := $(PAGES) hknob_cli

# Where this is set, as in some containers, each of hundreds of commands would parse the whole program anew.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help docs fuzz sweep every-start paper ladder maps smoke test long matrix firmware target lint schemas compare bench clean

help: ## this list
	@grep -hE '^[a-z-]+:.*##' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "make %-11s %s\n", $$1, $$2}'

$(VENV)/.made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "hknob needs Python 3.11 or newer, found " + sys.version.split()[0] + "; choose one with make PYTHON=...")'
	@echo "making $(VENV)" >&2
	@$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.run: $(VENV)/.made pyproject.toml constraints.txt
	@echo "installing pinned dependencies" >&2
	@$(PIP) --editable .
	@touch $@

$(VENV)/.dev: $(VENV)/.made pyproject.toml constraints.txt
	@echo "installing pinned dependencies, with those of the tests" >&2
	@$(PIP) --no-compile --editable '.[dev]'
	@touch $@ $(VENV)/.run

$(VENV)/.docs: $(VENV)/.made pyproject.toml constraints.txt
	@echo "installing pinned dependencies, with those of the pages" >&2
	@$(PIP) --editable '.[docs]'
	@touch $@

sweep: $(VENV)/.run ## the 7x7 grid of sample rate and encoder resolution: table, files, picture
	@$(BIN)/hknob sweep experiments/hand_on_knob.yaml --plot --out $(OUT)/hand-on-knob

every-start: $(VENV)/.run ## that grid from every start within 50 mrad and 5 rad/s: all limit cycles there are, proven
	@$(BIN)/hknob sweep experiments/every_start.yaml --plot --out $(OUT)/every-start

paper: $(VENV)/.run ## the dissertation, recomputed: every figure and claim on one page; again, only what has changed
	@$(BIN)/hknob run experiments/dissertation.yaml --out $(OUT)/dissertation

maps: $(VENV)/.run ## every sweep in experiments/, with pictures
	@for spec in $$(grep -l '^kind: sweep' experiments/*.yaml); do \
	    echo "== $$spec"; $(BIN)/hknob sweep $$spec --plot --out $(OUT)/$$(basename $$spec .yaml) || exit 1; done

ladder: $(VENV)/.run ## that grid at half a count's bias: formulas, describing functions, exact cycles, with pictures
	@$(BIN)/hknob sweep experiments/hand_on_knob_half_quantum.yaml --out $(OUT)/half-quantum
	@$(BIN)/hknob predict experiments/predict_hand_on_knob.yaml --plot --out $(OUT)/predict \
	    --set 'scene.bias={half_quantum: true}' --set against=$(OUT)/half-quantum
	@$(BIN)/hknob dfa experiments/dfa_hand_on_knob.yaml --plot --out $(OUT)/dfa --set against=$(OUT)/half-quantum

smoke: $(VENV)/.run ## every kind of stage on a 3x3 grid, in seconds
	@$(BIN)/hknob run experiments/smoke.yaml --out $(OUT)/smoke

test: $(VENV)/.dev ## lint, types, prose, and the tests except the long ones; ends with what was left out, and why
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check --quiet .
	@$(BIN)/codespell $(TEXTS)
	@$(BIN)/python -m tests.docs.prose $(PAGES)
	@$(BIN)/mypy $(if $(CI),--no-incremental) > $(VENV)/types.txt 2>&1 & types=$$!; \
	    $(BIN)/python -m pytest -n $(WORKERS) --dist loadfile --no-loadscope-reorder --compiled -rs -m 'not long'; \
	    tests=$$?; wait $$types; types=$$?; cat $(VENV)/types.txt; exit $$((tests ? tests : types))

long: $(VENV)/.dev ## the tests that take minutes: dissertation, clusters, kills, odd inputs; ALL=1: every case
	@$(BIN)/python -m pytest -n $(WORKERS) --compiled -rs -m long $(if $(ALL),,--draw $(DRAW))

matrix: $(VENV)/.dev ## the wheel in a foreign folder: other Pythons, lowest and newest dependencies; licences
	@$(BIN)/python -m tests.matrix.run $(if $(ENDS),--ends)

firmware: $(VENV)/.dev ## the control loop in C, built as a process and for QEMU, and tested; says what it needs
	@$(BIN)/python -m pytest -rs tests/hardware/test_firmware_wire.py tests/hardware/test_firmware_states.py
	@$(MAKE) --no-print-directory target

target: $(VENV)/.run ## that, only built: its tests are among those of make test
	@$(BIN)/python -m hknob_cli.hardware.reference_target $(OUT)/firmware

lint: $(VENV)/.dev ## lint, format, types, words and sentences, mending what can be mended
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .
	@$(BIN)/mypy
	@$(BIN)/codespell $(TEXTS)
	@$(BIN)/python -m tests.docs.prose $(PAGES)

schemas: $(VENV)/.run ## regenerate schemas/ and the pages of docs/reference/ that are made from the program
	@for kind in $$($(BIN)/python -m hknob_cli.stage_table); do \
	    $(BIN)/hknob schema $$kind > schemas/$$kind.schema.json || exit 1; done
	@$(BIN)/python -c 'from hknob_cli.page.reference import reference; print(reference(), end="")' > docs/reference/page.md
	@$(BIN)/python -c 'from hknob_cli.specs.generated import capabilities_page; print(capabilities_page(), end="")' > docs/reference/capabilities.md
	@$(BIN)/python -c 'from hknob_cli.specs.generated import presets_page; print(presets_page(), end="")' > docs/reference/presets.md
	@for name in columns spec_keys contents; do $(BIN)/python docs/make/$$name.py > docs/reference/$$name.md || exit 1; done
	@$(BIN)/python docs/make/signs.py
	@$(BIN)/hknob explore --no-open --json --out docs/play/knob.html > /dev/null

docs: $(VENV)/.docs ## the pages of docs/ as a site with a search, to open in a browser without a server
	@NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet --site-dir $(abspath $(OUT)/site)
	@echo "open $(OUT)/site/index.html"

compare: $(VENV)/.dev ## error against run time in 35 scenes, stiff and extreme ones included, with pictures; minutes
	@$(BIN)/hknob bench experiments/bench.yaml --plot --out $(OUT)/bench

fuzz: $(VENV)/.run ## odd specs, tables and sessions, COUNT of each, other ones by SEED; saves what breaks a rule
	@$(BIN)/python tests/fuzz/campaign.py --count $(COUNT) --seed $(SEED) --workers $$(nproc) --save $(OUT)/fuzz
	@if $(BIN)/python -c 'import atheris' 2>/dev/null; then $(BIN)/python tests/fuzz/guided.py --save $(OUT)/fuzz; \
	    else echo "not led by coverage: needs atheris ($(BIN)/python -m pip install atheris)"; fi

bench: $(VENV)/.dev ## throughput, many cells, start-up, rivals, identification; a line of ratios beside the last
	@$(BIN)/python tests/benchmarks/record.py

clean: ## remove the environment, caches and results
	@rm -rf $(VENV) results build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +
