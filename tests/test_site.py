"""The site: it builds without a warning, its links lead somewhere, and its pages say what the recorded timing shows."""

import html.parser
import importlib
import pathlib
import re
import subprocess
import sys
import urllib.parse

import pytest


ROOT = pathlib.Path(__file__).parent.parent
SITE = ROOT / "docs" / "site"

for package in ("sphinx", "myst_parser", "furo", "wavedrom"):
    pytest.importorskip(package, reason=f"{package}, of the extra site, is not installed")


@pytest.fixture
def module(monkeypatch):
    """Imports a module of the site's configuration."""
    monkeypatch.syspath_prepend(str(SITE))
    yield importlib.import_module
    for name in ("conf", "pictures", "references", "staging", "timing"):
        sys.modules.pop(name, None)


def build(folder, *options, source="source"):
    (folder / source).mkdir(exist_ok=True)
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", *options, "-c", str(SITE), "-d", str(folder / "trees"),
               str(folder / source), str(folder / "site")]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=1200)


class Page(html.parser.HTMLParser):
    """Links and anchors of a page, and what a browser loads with it."""
    def __init__(self, path):
        super().__init__()
        self.links, self.anchors, self.loaded = set(), set(), set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        self.links |= {found[name] for name in ("href", "src") if found.get(name)}
        self.loaded |= {found[name] for name in ("src", *["href"] * (tag == "link")) if found.get(name)}


def broken(site):
    """Links of all pages, within the site, that lead nowhere."""
    pages = {path: Page(path) for path in site.rglob("*.html")}
    for path, page in pages.items():
        for link in page.links:
            url = urllib.parse.urlsplit(link)
            target = (path.parent / urllib.parse.unquote(url.path)).resolve() if url.path else path
            anchors = pages[target].anchors if target in pages else {""}
            if not url.scheme and (not target.exists() or (url.fragment and urllib.parse.unquote(url.fragment) not in anchors)):
                yield f"{path.relative_to(site)}: {link}"


def test_pages(tmp_path):
    """All but those of the API. In one test, so that they are built once."""
    run = build(tmp_path, "-t", "pages")
    assert (run.returncode, run.stderr) == (0, "")
    site = tmp_path / "site"
    assert [*broken(site)] == []
    documents = [*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("docs/site/*.md")]
    assert [path for path in documents if not (site / path.relative_to(ROOT)).with_suffix(".html").exists()] == []
    assert not any(urllib.parse.urlsplit(link).scheme for path in site.rglob("*.html") for link in Page(path).loaded)
    front = (site / "index.html").read_text(encoding="utf-8")
    assert (site / re.search('url=(.*?)"', front)[1]).exists()


# The pages of the API take five times as long as all others; docstrings seldom break them.
@pytest.mark.slow
def test_whole_site(tmp_path):
    run = build(tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert [*broken(tmp_path / "site")] == []


def test_sources_are_copies(module, tmp_path):
    staging = module("staging")
    stale = tmp_path / "docs" / "gone.md"
    stale.parent.mkdir()
    stale.touch()
    staging.stage(tmp_path, {"docs/site/new.svg": b"new"})
    assert not stale.exists() and (tmp_path / "docs/site/new.svg").read_bytes() == b"new"
    assert (tmp_path / "README.md").read_bytes() == (ROOT / "README.md").read_bytes()
    before = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.*")}
    staging.stage(tmp_path, {"docs/site/new.svg": b"newer"})
    assert [path.name for path, time in before.items() if path.is_file() and path.stat().st_mtime_ns != time] == ["new.svg"]


@pytest.mark.parametrize("folder", [ROOT, ROOT.parent, SITE])
def test_the_repository_is_not_overwritten(module, folder):
    with pytest.raises(ValueError, match="would replace all in"):
        module("staging").stage(folder, {})


def test_each_room_has_a_page(module):
    pages = module("staging").api_pages()
    rooms = (path.parent for package in ("golden", "hdl", "boards", "sim") for path in (ROOT / package).rglob("__init__.py"))
    names = {".".join(room.relative_to(ROOT).parts) for room in rooms}
    assert pages.keys() == {"docs/site/api.md", *(f"docs/site/api/{name}.rst" for name in names)}
    index = pages["docs/site/api.md"].decode()
    assert names == {*re.findall(r"^api/(.*)$", index, re.MULTILINE)}
    page = pages["docs/site/api/golden.matcher.rst"].decode()
    assert ".. automodule:: golden.matcher\n" in page and ".. automodule:: golden.matcher.cost\n   :members:\n" in page
    package = pages["docs/site/api/golden.rst"].decode()
    assert ".. automodule:: golden.dataset\n\n" in package     # its members are another's
    assert "__main__" not in package and "_tb" not in pages["docs/site/api/sim.benches.rst"].decode()


@pytest.mark.parametrize("name, owners", [
    ("golden.config.METHODS", ["golden.config.METHODS", "golden.config"]),
    ("golden.config.MatcherConfig", ["golden.config.matcher.MatcherConfig", "golden.config"]),     # where it is defined
    ("golden.config.MatcherConfig.labels",
     ["golden.config.matcher.MatcherConfig.labels", "golden.config.matcher.MatcherConfig", "golden.config"]),
    ("boards.registry.Project.files", ["boards.registry.Project.files", "boards.registry.Project", "boards.registry"]),    # has no default
    ("golden.config.Matcher", []),
    ("golden.nothing.MatcherConfig", []),
    ("nothing", []),
])
def test_names_are_those_that_python_knows(module, name, owners):
    assert [*module("references")._owners(name)] == owners


def test_sections_of_docstrings(module):
    references = module("references")
    lines = ["Ports.", "", "Members", "-------", "i : In(1)", "    Input."]
    references.sections(None, "class", "a", object(), None, lines)
    assert ":Members: **i** (*In(1)*) -- Input." in lines
    told = ["Pause: after which it is ready."]
    references.sections(None, "property", "a", object(), None, told)
    assert told == ["Pause: after which it is ready."]


def transfers(trace, name):
    """Clocks of a stream's transfers, and the grey levels."""
    moved = zip(trace[f"{name}.valid"], trace[f"{name}.ready"], trace[f"{name}.p.left"], strict=True)
    return [(clock, left) for clock, (valid, ready, left) in enumerate(moved) if valid and ready]


def test_timing_is_as_the_page_says(module):
    timing = module("timing")
    trace = timing.back_pressure()
    pixels = ["00", "01", "02", "10", "11", "12"]
    for name in "io":
        assert [left for _, left in transfers(trace, name)] == pixels
        assert [trace[f"{name}.p.{flag}"][clock] for flag in ("first", "last", "end") for clock, _ in transfers(trace, name)] == [
            *(1, 0, 0, 0, 0, 0), *(0, 0, 1, 0, 0, 1), *(0, 0, 0, 0, 0, 1)]
    low = {name: [clock for clock, level in enumerate(trace[name]) if not level] for name in ("i.valid", "o.valid", "i.ready", "o.ready")}
    assert low == {"i.valid": [3, 10, 11], "o.valid": [0, 4, 11], "i.ready": [6, 7, 8], "o.ready": [5, 6, 7]}
    assert trace["o.p.left"][5:9] == ["10"] * 4 and trace["i.p.left"][6:10] == ["12"] * 4

    trace = timing.frame_timing()
    assert [left for _, left in transfers(trace, "o")] == pixels
    taken = [clock for clock, level in enumerate(trace["pixel_valid"]) if level]
    fall = trace["frame_valid"].index(0, 1)
    assert [clock for clock, _ in transfers(trace, "o")] == [clock + 2 for clock in [*taken[1:], fall]]


def test_diagrams_draw_levels_and_values(module):
    timing = module("timing")
    assert timing._lane("a", [1, 1, 0, None, "12", "12", "13"]) == {"name": "a", "wave": "1.0x=.=", "data": ["12", "13"]}
    assert timing.svg({"valid": [0, 1]}).startswith(b"<svg") and set(timing.diagrams()) == {"back_pressure.svg", "frame_timing.svg"}
