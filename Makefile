# Everything Python lives in .venv, made here from $(PYTHON); the system's packages are never touched.
#   make demo    draw a photo to out/, with Python and with the native binary
#   make test    Rust and Python tests          make lint    formatters, linters, types
#   make bench   speed                          make format  apply the formatters
#   make build   the package in .venv           make clean   remove everything made here
#   make docs    the documentation as a site in out/docs; a warning is an error
#   make generate   what is made from the declarations of options and from the tree: Python's fields, docs/options.md,
#                   docs/command-line.md, ARCHITECTURE.md
#   make performance   the tables of docs/performance.md anew, for an idle machine
#   make peers   speed beside other programs, which it installs into out/peers
#   make fuzz   look for input that breaks the reading of images, options or drawings, FUZZ_SECONDS for each of FUZZ_TARGETS
#   make evaluate   compare methods on scikit-image's photos: a report in out/evaluation
#   make ablation   what each step of the default brings, on the same photos and those of MORE
PYTHON ?= python3
VENV := .venv
BIN := $(CURDIR)/$(VENV)/bin
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
export PYO3_PYTHON := $(BIN)/python
unexport CONDA_PREFIX

RUST := $(shell find rust -name '*.rs' -o -name '*.md' -o -name Cargo.toml) Cargo.toml Cargo.lock
ENVIRONMENT := $(VENV)/.environment-done
PACKAGE := $(VENV)/.package-done
EVALUATION := $(VENV)/.evaluation-done
BINARY := target/release/graphstipple
# Both packages are named so that libraries have the features that the extension wants: they are built once for both.
BUILD_BINARY := cargo build --release --locked --package graphstipple-cli --package graphstipple-py --bin graphstipple

# What `make fuzz` runs, and for how long; FUZZ_SEEDS may name more files and folders to begin with.
FUZZ_TARGETS := jpeg png tiff webp exif_and_any profile options drawing_svg drawing_json areas
FUZZ_SECONDS := 600
FUZZ_SEEDS :=

# Public-domain photos in scikit-image's wheel; MORE may name photos and folders for `make ablation`.
PHOTOS := astronaut.png camera.png chelsea.png coffee.png rocket.jpg
FIND_PHOTOS = folder=$$($(BIN)/python -c 'from skimage.data import data_dir; print(data_dir)')
MORE :=

# The environment is installed while the binary is built.
MAKEFLAGS += --jobs=2

.PHONY: build binary demo test lint format docs generate bench performance peers evaluate ablation fuzz clean
build: $(PACKAGE)

$(ENVIRONMENT): requirements-dev.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
	    { echo "graphstipple needs Python 3.10 or newer, but $(PYTHON) is older: try make PYTHON=python3.12" >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' || \
	    { echo "$(PYTHON) cannot make virtual environments; on Debian and Ubuntu: apt-get install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -r requirements-dev.lock
	touch $@

$(PACKAGE): $(ENVIRONMENT) pyproject.toml $(RUST)
	$(BIN)/maturin develop --release --locked --quiet
	touch $@

$(EVALUATION): $(PACKAGE) benches/evaluation/pyproject.toml
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e benches/evaluation
	touch $@

binary:
	$(BUILD_BINARY)

demo: $(PACKAGE) binary
	$(BIN)/python examples/demo.py out
	$(BINARY) out/astronaut.png -o out/astronaut-binary.svg --preview out/astronaut-binary.png
	cmp out/astronaut.svg out/astronaut-binary.svg
	@echo "The native binary drew the same: out/astronaut-binary.svg"

# The package of the extension is named with the core for the same reason as above. What stands around the core, and its examples,
# are tested with the core as it is in the package.
test: $(PACKAGE) $(EVALUATION) binary
	cargo test --release --locked --config rust/checked.toml --package graphstipple-core --package graphstipple-py --lib
	cargo test --release --locked --workspace --exclude graphstipple-core
	cargo test --release --locked --package graphstipple-core --package graphstipple-py --example draw
	cargo test --release --locked --package graphstipple-core --package graphstipple-py --doc
	# Once, and not by every process of the tests; what needs the weights says so if they are missing.
	-$(BIN)/python -m graphstipple.metrics fetch
	$(BIN)/python -m pytest --numprocesses auto --dist loadgroup

lint: $(PACKAGE) $(EVALUATION) docs
	cargo fmt --all --check
	cargo clippy --release --workspace --all-targets --locked -- -D warnings
	cargo fmt --manifest-path fuzz/Cargo.toml --check
	# With a name in place of libFuzzer, which only linking needs, it is not compiled.
	CUSTOM_LIBFUZZER_PATH=target/libFuzzer.a cargo clippy --release --manifest-path fuzz/Cargo.toml --target-dir target --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --release --package graphstipple-core --package graphstipple-cli --no-deps --locked --quiet
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest graphstipple._core

format: $(ENVIRONMENT)
	cargo fmt --all
	cargo fmt --manifest-path fuzz/Cargo.toml
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

docs: $(PACKAGE)
	$(BIN)/sphinx-build --quiet --fail-on-warning --keep-going --fresh-env -c docs . out/docs

generate: $(PACKAGE)
	$(BIN)/python tools/generate.py

bench: $(PACKAGE) binary
	cargo bench --package graphstipple-bench --locked --bench stages
	cargo bench --package graphstipple-bench --locked --bench scale -- --up-to 24
	cargo bench --package graphstipple-bench --locked --bench formats
	cargo bench --package graphstipple-bench --locked --bench threads
	$(BIN)/python benches/ratios.py
	$(BIN)/python benches/studio.py
	$(BIN)/python benches/plots.py

peers: $(EVALUATION) binary
	$(BIN)/python benches/peers.py

performance: $(EVALUATION) binary
	$(BIN)/python benches/document.py

evaluate: $(EVALUATION)
	$(BIN)/python -m graphstipple.metrics fetch
	$(FIND_PHOTOS) && \
	    $(BIN)/graphstipple-eval $(PHOTOS:%="$$folder/%") --size 512 --out out/evaluation

ablation: $(EVALUATION)
	$(BIN)/python -m graphstipple.metrics fetch
	$(FIND_PHOTOS) && \
	    $(BIN)/python -m graphstipple_eval.ablation $(PHOTOS:%="$$folder/%") $(MORE) --size 512 --out out/ablation

# No sanitizer, which only a nightly compiler knows: there is no unsafe code to watch here.
fuzz: $(PACKAGE)
	@cargo fuzz --version >/dev/null || { echo "cargo-fuzz is missing: cargo install cargo-fuzz" >&2; exit 1; }
	$(BIN)/python -m fuzz.seeds $(FUZZ_SEEDS)
	CARGO_PROFILE_RELEASE_DEBUG=line-tables-only cargo fuzz build --sanitizer none
	for target in $(FUZZ_TARGETS); do \
	    CARGO_PROFILE_RELEASE_DEBUG=line-tables-only cargo fuzz run --sanitizer none $$target -- \
	        -max_total_time=$(FUZZ_SECONDS) -max_len=32768 -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 || exit 1; \
	done

clean:
	rm -rf $(VENV) target fuzz/target fuzz/corpus fuzz/artifacts fuzz/coverage out dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	rm -f python/graphstipple/_core*.so python/graphstipple/_core*.pyd
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
