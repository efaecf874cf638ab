# `make demo` and `make test` install what they need: Debian packages that are missing (as root, or through sudo), then the
# Python packages into a virtual environment. What is there already is left alone.

PYTHON ?= python3
VENV   ?= .venv

# Recipes read these from the environment, in quotes: make itself would split a path at a space, in targets and functions too.
export PYTHON VENV
WITH_BIN := PATH="$$(CDPATH= cd -- "$$VENV/bin" && pwd):$$PATH"
RUN      := "$$VENV/bin/python"
# On all cores; one that has no test left gets some of another's.
PARALLEL := -n auto --dist worksteal

.PHONY: help demo quick test slow formal site style types setup debian clean
.DELETE_ON_ERROR:

help:
	@echo "make demo    set up, then send the Motorcycle stereo pair through the simulated Verilog; the sheet is build/demo/sheet.png"
	@echo "make test    set up, then run all tests: style, types, golden model, gateware, benches"
	@echo "make quick   set up, then run what takes seconds: style, types, golden model, blocks of the gateware; before each commit"
	@echo "make slow    set up, then run the tests that make test leaves out because they take minutes each, and tell how long they took"
	@echo "make formal  set up, then prove what is claimed of all components for all inputs; some minutes of a processor"
	@echo "make site    set up, then build the documentation as a site from docs/ and the docstrings; it begins at build/site/index.html"
	@echo "make style   set up, then check the style only; make types: the types only"
	@echo "make setup   only set up: Debian packages that are missing, Python packages in $$VENV"
	@echo "make clean   remove what was built and cached; $$VENV stays"
	@echo "Variables: PYTHON=$$PYTHON (3.11 or newer), VENV=$$VENV"

demo: setup
	@$(WITH_BIN) $(RUN) -m sim.demo

test: setup
	@$(WITH_BIN) $(RUN) -m pytest $(PARALLEL)

# Under 90 seconds on two cores: benches on Verilog, boards and simulations of whole matchers, of video and of the host's line are left to `make test`.
QUICK := tests/test_style.py tests/test_repository.py golden tests/golden tests/hdl/parts tests/hdl/matcher/sequential tests/hdl/matcher/test_settings.py

quick: setup
	@$(WITH_BIN) $(RUN) -m pytest $(PARALLEL) $(QUICK)

slow: setup
	@$(WITH_BIN) sh -c 'start=$$(date +%s); $(RUN) -m pytest $(PARALLEL) -m slow; status=$$?; \
		echo "The slow tests took $$(( ($$(date +%s) - start + 30) / 60 )) minutes."; exit $$status'

formal: setup
	@$(WITH_BIN) $(RUN) -m sim.verify proofs

# A warning is an error. Sources are copies: what is made for the site is put beside them.
site: setup
	@reason=$$($(RUN) -c "import furo, matplotlib, myst_parser, sphinx, wavedrom" 2>&1) || \
		{ echo "make site: $${reason##*Error: }; remove $$VENV/.installed, and make site installs it" >&2; exit 2; }
	@mkdir -p build/site-source
	@$(RUN) -m sphinx -q -W --keep-going -c docs/site -d build/site-trees build/site-source build/site
	@echo "The site is build/site/index.html."

style: setup
	@$(RUN) -m ruff check --no-fix golden hdl boards sim docs tests

types: setup
	@$(RUN) -m mypy

# The virtual environment is kept when a dependency changes: pip brings it up to date.
setup: debian
	@if [ ! -e "$$VENV/.installed" ] || [ pyproject.toml -nt "$$VENV/.installed" ]; then sh -c "$$INSTALL"; fi

debian:
	@sh -c "$$DEBIAN"

clean:
	rm -rf build *.egg-info .pytest_cache .ruff_cache .mypy_cache
	find golden hdl boards sim tests -name __pycache__ -prune -exec rm -rf {} +

define INSTALL
stop() { echo "$$*" >&2; exit 1; }
echo "Installing the Python packages into $$VENV: 170 MB to download at first, 680 MB on disk."
test -x "$$VENV/bin/pip" || "$$PYTHON" -m venv "$$VENV" 2>/dev/null || "$$PYTHON" -m virtualenv --quiet "$$VENV" ||
    stop "A virtual environment cannot be made in $$VENV with $$PYTHON."
"$$VENV/bin/python" -m pip install --quiet --disable-pip-version-check --editable ".[demo,sim,resources,boards,console,registers,lab,site,test]" ||
    stop "The Python packages cannot be installed into $$VENV; pip's reason is above."
touch "$$VENV/.installed"
endef
export INSTALL

# Verilator compiles with g++ and is started by a Perl script; cocotb loads Python as a shared library into the simulator. A board's script
# for Quartus is Tcl. GHDL analyses the VHDL of --package vhdl; mcode is its smallest kind, 20 MB with its libraries.
define DEBIAN
missing() {
    command -v g++ >/dev/null || echo g++
    command -v iverilog >/dev/null || echo iverilog
    command -v tclsh >/dev/null || echo tcl
    command -v ghdl >/dev/null || echo ghdl-mcode
    perl -MPod::Usage -e 1 2>/dev/null || echo perl
    if ! command -v "$$PYTHON" >/dev/null; then
        echo python3-venv libpython3-dev
        return
    fi
    version=$$("$$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    "$$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || "$$PYTHON" -m virtualenv --version >/dev/null 2>&1 || echo "python$$version-venv"
    "$$PYTHON" -c 'import ctypes, sysconfig; ctypes.CDLL(sysconfig.get_config_var("INSTSONAME"))' 2>/dev/null || echo "libpython$$version"
}
stop() { echo "$$*" >&2; exit 1; }

packages=$$(echo $$(missing))
if [ -n "$$packages" ]; then
    command -v apt-get >/dev/null || stop "These Debian packages, or what your system calls them, are missing: $$packages."
    sudo=
    if [ "$$(id -u)" != 0 ]; then
        sudo=sudo
        command -v sudo >/dev/null || stop "Neither root nor sudo: ask for 'apt-get install $$packages'."
    fi
    echo "Installing the Debian packages $$packages."
    $$sudo apt-get update -qq || echo "The list of Debian packages cannot be updated; trying the present one." >&2
    $$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $$packages >/dev/null ||
        stop "These Debian packages cannot be installed; apt-get's reason is above: $$packages."
    packages=$$(echo $$(missing))
    [ -z "$$packages" ] || stop "Still missing although apt-get succeeded: $$packages."
fi
"$$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || stop "$$PYTHON is older than 3.11: name a newer one, as in 'make test PYTHON=python3.12'."
endef
export DEBIAN
