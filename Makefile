# Everything sets itself up: a fresh machine needs Python 3.11+ and make, nothing else.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.installed
MODEL  := $(VENV)/.landmarks
EXTRAS ?= all

# The compiled loops have threads of their own; BLAS threads beside them only get in the way.
export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo docs test test-clients lint bench clean setup house mutants

demo: $(STAMP)
	@echo "a performer is staged, recorded and solved: about a minute, and once 20 s more to compile"
	$(BIN)/mien demo markers

# The types are checked beside the tests: one process leaves a core idle.
test: setup
	$(BIN)/ruff check src tests tools benchmarks examples clients
	@$(BIN)/pyright --level error > .pyright.log 2>&1 & types=$$!; \
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder; tests=$$?; \
	wait $$types; types=$$?; tail -n 40 .pyright.log; rm -f .pyright.log; \
	[ $$tests -eq 0 ] && [ $$types -eq 0 ]

lint: $(STAMP)
	$(BIN)/ruff check src tests tools benchmarks examples
	$(BIN)/pyright --level error

bench: setup
	@for b in benchmarks/[a-z]*.py; do echo "== $$b"; $(BIN)/python $$b || exit 1; done

# The documentation as a site: build/site/index.html.
docs: $(STAMP)
	@$(BIN)/python -c "import material" 2>/dev/null || \
	  if command -v uv >/dev/null 2>&1; then uv pip install -q --python $(BIN)/python -e '.[docs]'; \
	  else $(BIN)/python -m pip install -q --disable-pip-version-check -e '.[docs]'; fi
	$(BIN)/python tools/book.py build/book
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build -q --strict

# What is written, in the programs that it is for: Blender (its Python module, about 300 MB, in an environment of its own,
# since it wants an older numpy and one Python alone) and three.js in headless Chromium.
CLIENTS := .venv-clients
BPY     ?= bpy==5.0.1

test-clients: $(STAMP) $(CLIENTS)/.installed
	$(BIN)/python -m pytest clients -p no:cacheprovider --override-ini pythonpath='clients tests' -s

$(CLIENTS)/.installed:
	test -x $(CLIENTS)/bin/python || $(PYTHON) -m venv $(CLIENTS)
	$(CLIENTS)/bin/python -m pip install -q --disable-pip-version-check '$(BPY)'
	@touch $@

setup: $(STAMP) $(MODEL)
	@command -v chromium chromium-browser google-chrome >/dev/null || \
	  echo "tests of the page are skipped: no Chromium (Debian: apt install chromium)"

house: $(STAMP)
	$(BIN)/python tools/house.py

# Switches every named step off, one by one, and lists what no test misses: half an hour, or STEPS=tracking for a part.
mutants: setup
	$(BIN)/python tools/mutants.py $(STEPS)

$(STAMP): pyproject.toml
	@echo "installing into $(VENV), once: a minute or two"
	@if command -v uv >/dev/null 2>&1; then \
	  test -x $(BIN)/python || uv venv -q --python $(PYTHON) $(VENV); \
	  uv pip install -q --python $(BIN)/python -e '.[$(EXTRAS),dev]'; \
	else \
	  test -x $(BIN)/python || $(PYTHON) -m venv $(VENV); \
	  $(BIN)/python -m pip install -q --disable-pip-version-check -e '.[$(EXTRAS),dev]'; \
	fi
	@touch $@

# The landmark model, once. Without a network all goes on, and is tried again the next time.
$(MODEL): $(STAMP)
	@if $(BIN)/mien fetch landmarks; then touch $@; else \
	  echo "set-up goes on: what finds faces in pictures stops with the line above until that is mended"; fi

clean:
	rm -rf $(VENV) $(CLIENTS) demo build dist
