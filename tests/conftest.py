"""Settings for all tests: the same Verilog everywhere, the environment's tools on the path, no skipped tests where all can run."""

import os
import pathlib
import sys
import tempfile

import pytest
from hypothesis import HealthCheck, configuration, settings


# Another Yosys prints other text. Set before anything imports Amaranth's back end.
os.environ["AMARANTH_USE_YOSYS"] = "builtin"
# The tools that pip installed beside this Python are found without activating the environment.
os.environ["PATH"] = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])


# Examples are the same in every run, whatever the machine's load, and none is kept: a failure is that of the sources.
# `deep` is for `python -m sim.verify properties`.
FIXED = settings(derandomize=True, deadline=None, database=None, print_blob=False, suppress_health_check=list(HealthCheck))
settings.register_profile("fixed", FIXED, max_examples=20)
settings.register_profile("deep", FIXED, max_examples=1000)
settings.load_profile("fixed")
# What Hypothesis caches is no file of the repository.
configuration.set_hypothesis_home_dir(pathlib.Path(tempfile.gettempdir()) / "hypothesis")


class NoSkips:
    """Turns each skip into a failure with the skip's reason; `.ci/run` asks for it by ``STEREO_REQUIRE_ALL=1``."""

    @staticmethod
    def refuse(report):
        expected_failure = hasattr(report, "wasxfail")
        if report.skipped and not expected_failure:
            *_, reason = report.longrepr
            report.outcome = "failed"
            report.longrepr = f"STEREO_REQUIRE_ALL=1 allows no skip, but: {reason}"
        return report

    # Outermost, to see the report as it is counted.
    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(self):
        return self.refuse((yield))

    # A whole module may skip itself while it is collected.
    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_make_collect_report(self):
        return self.refuse((yield))


def pytest_configure(config):
    # Hooks written in this file would see the tests of this folder only; those of a plugin see the benches in sim/ too.
    if os.environ.get("STEREO_REQUIRE_ALL", "0") != "0":
        config.pluginmanager.register(NoSkips())
