"""Generated pages are in step with their sources: each names its command and the digest of what it was made from."""

import functools
import pathlib

import pytest

from golden.lab.rivals import compare
from golden.lab.thesis import command, specimen
from golden.lab.thesis.resources import read_resources
from golden.pages import digest, origin, read_origin
from golden.pictures.checksums import PIXEL_SUMS, sums
from golden.pictures.scenes import SCENES


ROOT = pathlib.Path(__file__).parent.parent
DOCS = ROOT / "docs"

# Every page, and the command that writes it.
COMMANDS = {
    "compare.md": "python -m golden compare --output docs/compare.png --page docs/compare.md",
    "core_registers.md": "python -m golden.host.register_page --core --output docs/core_registers.md",
    "loop_registers.md": "python -m golden.host.register_page --loop --output docs/loop_registers.md",
    "registers.md": "python -m golden.host.register_page --output docs/registers.md",
    "resources.md": "python -m hdl.resources.tables --clock docs/clock.json",
    "thesis.md": "python -m golden thesis",
    "thesis.html": "python -m golden thesis",
    "verification.md": "python -m sim.verify report",
}


@pytest.mark.parametrize("page", COMMANDS)
def test_page_names_its_command(page):
    command, _ = read_origin((DOCS / page).read_text(encoding="utf-8"))
    assert command == COMMANDS[page]


def test_page_of_the_comparison_is_of_these_inputs():
    """The pictures that are compared, and what the methods give on small scenes, are as when the page was written."""
    for package in ("cv2", "skimage"):
        pytest.importorskip(package, reason=f"{package}, of the extras lab and demo, is not installed")
    inputs = compare.inputs([compare.motorcycle_view(), *compare.views(SCENES)], compare.DEFAULT_METHODS, 1.0)
    assert read_origin((DOCS / "compare.md").read_text(encoding="utf-8"))[1] == inputs, f"run {COMMANDS['compare.md']}"


def test_thesis_pages_are_of_these_inputs():
    """What is measured on small pairs, the benchmark's checksums and docs/resources.md are as when the pages were written."""
    for package in ("cv2", "maxflow"):
        pytest.importorskip(package, reason=f"{package}, of the extra lab, is not installed")
    chapters = functools.partial(command.chapters, resources=read_resources(DOCS / "resources.md"))
    inputs = specimen.inputs(chapters, sums(PIXEL_SUMS))
    for page in ("thesis.md", "thesis.html"):
        assert read_origin((DOCS / page).read_text(encoding="utf-8"))[1] == inputs, f"docs/{page} is stale: run {COMMANDS[page]}"


def test_pages_without_an_origin_are_written_by_hand():
    named = {path.name for pattern in ("*.md", "*.html") for path in DOCS.glob(pattern)
             if "Digest of its inputs" in path.read_text(encoding="utf-8")}
    assert named == set(COMMANDS)


def test_digest_is_of_values():
    one = digest({"a": 1, "b": [2.5, "x", None]}, (3, 4))
    assert one == digest({"b": [2.5, "x", None], "a": 1}, [3, 4])
    assert len({one, digest({"a": 1, "b": [2.5, "y", None]}, (3, 4)), digest({"a": 1, "b": [2.5, "x", None]}, (4, 3)), digest()}) == 4


@pytest.mark.parametrize("text, found", [("# Page", 0), (origin("a", digest(1)) + origin("b", digest(2)), 2), ("Written by `a`.", 0)])
def test_no_origin(text, found):
    with pytest.raises(ValueError, match=f"names {found} commands and digests, not 1; write it again with its command"):
        read_origin(text)


def test_origin_in_html():
    text = "<p>" + origin("make page", digest(1)).replace("`make page`", "<code>make page</code>")
    assert read_origin(text) == ("make page", digest(1))
