"""The files around the code: continuous integration, hooks and documents name targets, modules, options and files that exist."""

import importlib
import importlib.util
import pathlib
import re
import tomllib

import pytest
import yaml


ROOT = pathlib.Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
HOOKS = ROOT / ".pre-commit-config.yaml"
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
# Pages of the site only. Their pictures are made when it is built, which checks their links, tests/test_site.py.
SITE = sorted(ROOT.glob("docs/site/*.md"))
# The changelog names what there was.
CURRENT = [path for path in DOCUMENTS if path.name != "CHANGELOG.md"] + SITE


def text(path):
    return path.read_text(encoding="utf-8")


def name(path):
    return str(path.relative_to(ROOT))


def phony_targets():
    declared, = re.findall(r"^\.PHONY: (.*)$", text(ROOT / "Makefile"), re.MULTILINE)
    targets = set(declared.split())
    assert targets <= set(re.findall(r"^([\w-]+):", text(ROOT / "Makefile"), re.MULTILINE))
    return targets


def made(command):
    """Targets of the `make` commands in a text; options and variables are none."""
    return {word for words in re.findall(r"\bmake((?: +[\w=.-]+)+)", command) for word in words.split() if re.fullmatch(r"[a-z]+", word)}


def code(path):
    """Commands of a document: what is in backticks, and the lines of its code blocks without comments."""
    blocks = re.findall(r"^```[a-z]*$(.*?)^```$", text(path), re.MULTILINE | re.DOTALL)
    spans = re.findall(r"`[^`\n]+`", re.sub(r"^```.*?^```$", "", text(path), flags=re.MULTILINE | re.DOTALL))
    return "\n".join([*(re.sub(r"#.*", "", block) for block in blocks), *spans])


def help_of(module, command, capsys):
    """What `python -m MODULE [COMMAND] --help` prints."""
    entry = importlib.import_module(f"{module}.__main__" if module in ("golden", "hdl.resources", "sim.verify") else module)
    with pytest.raises(SystemExit):
        entry.main([*[command] * (module in ("golden", "sim.verify")), "--help"])
    return capsys.readouterr().out


def steps(workflow):
    return [step for job in workflow["jobs"].values() for step in job["steps"]]


def test_make_help_tells_every_target():
    told = set(re.findall(r"\bmake (\w+)", text(ROOT / "Makefile").partition("help:")[2].partition("\n\n")[0]))
    assert phony_targets() - {"help", "debian"} == told


def test_workflow_runs_what_ci_run_does():
    workflow, = (yaml.safe_load(text(path)) for path in WORKFLOWS)
    assert {True: {"push", "pull_request", "workflow_dispatch"}} == {True: set(workflow[True])}  # YAML 1.1 reads `on` as a truth value
    targets = [made(step.get("run", "")) for step in steps(workflow)]
    assert made(text(ROOT / ".ci" / "run").rpartition("exec ")[2]) == {"test"}
    assert {"test"} in targets and set.union(*targets) <= phony_targets()
    for job in workflow["jobs"].values():
        assert job["timeout-minutes"] <= 60
        assert [step["uses"].partition("@")[0] for step in job["steps"][:2]] == ["actions/checkout", "actions/setup-python"]


def test_workflow_takes_the_oldest_python():
    oldest = re.search(r'requires-python = ">=([\d.]+)"', text(ROOT / "pyproject.toml"))[1]
    versions = {step["with"]["python-version"] for path in WORKFLOWS for step in steps(yaml.safe_load(text(path)))
                if step.get("uses", "").startswith("actions/setup-python")}
    assert versions == {oldest}


def test_workflow_allows_skips():
    """Without the Middlebury pictures a test that needs them must be skipped, not fail."""
    def keys(value):
        if isinstance(value, dict):
            yield from value
        for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
            yield from keys(each)

    for path in WORKFLOWS:
        workflow = yaml.safe_load(text(path))
        assert "STEREO_REQUIRE_ALL" not in keys(workflow)
        assert not any("STEREO_REQUIRE_ALL" in step.get("run", "") for step in steps(workflow))
    assert "STEREO_REQUIRE_ALL=1" in text(ROOT / ".ci" / "run")


def test_hooks_run_the_tools_of_the_tests():
    repositories = yaml.safe_load(text(HOOKS))["repos"]
    assert [each["repo"] for each in repositories] == ["local"]
    hooks = {hook["id"]: hook for each in repositories for hook in each["hooks"]}
    entries = {identifier: made(hook["entry"]) for identifier, hook in hooks.items()}
    assert entries == {"ruff": {"style"}, "mypy": {"types"}, "quick": {"quick"}}
    assert {identifier for identifier, hook in hooks.items() if "stages" in hook} == {"quick"}  # before a push only
    assert set.union(*entries.values()) <= phony_targets()
    for hook in hooks.values():
        assert hook["language"] == "system" and hook["pass_filenames"] is False
    recipes = text(ROOT / "Makefile")
    assert "-m ruff check --no-fix golden hdl boards sim docs tests\n" in recipes and "-m mypy\n" in recipes


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_links_lead_somewhere(path):
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text(path)) if "://" not in link]
    assert [link for link in links if link and not (path.parent / link).exists()] == []


@pytest.mark.parametrize("path", DOCUMENTS + SITE, ids=name)
def test_tables_are_whole(path):
    """Every block of lines with bars starts with a head and a rule, and all its rows are as long: an empty line would cut it."""
    unfenced = re.sub(r"^```.*?^```", "", text(path), flags=re.MULTILINE | re.DOTALL)
    for block in re.findall(r"(?:^\|.*\n?)+", unfenced, re.MULTILINE):
        cells = [len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()]
        assert len(cells) > 2 and re.fullmatch(r"\|([ :-]+\|)+", block.splitlines()[1]), block
        assert len(set(cells)) == 1, block


@pytest.mark.parametrize("path", CURRENT, ids=name)
def test_targets_exist(path):
    assert made(code(path)) <= phony_targets()


@pytest.mark.parametrize("path", CURRENT, ids=name)
def test_modules_exist(path):
    modules = set(re.findall(r"python -m ((?:golden|hdl|boards|sim)[\w.]*)", text(path)))
    assert {module for module in modules if importlib.util.find_spec(module) is None} == set()


def commands(path):
    """Command lines of a document that start with `python -m`: module, first word, options."""
    for line in re.findall(r"python -m ((?:golden|hdl|boards|sim)[^\n`]*)", code(path)):
        module, *words = re.sub(r"[\[\]();,|]", " ", line).split()
        yield module, words[0] if words else "", tuple(sorted({word for word in words if re.match("--[a-z]", word)}))


@pytest.mark.parametrize("module, command, options", sorted({each for path in CURRENT for each in commands(path) if each[2]}))
def test_options_exist(module, command, options, capsys):
    assert set(options) <= set(re.findall(r"--[\w-]+", help_of(module, command, capsys)))


@pytest.mark.parametrize("option, start", [("--method", "`--method fused` chooses"), ("--engine", "Of these,")])
def test_readme_tells_which_commands_take_a_method(option, start, capsys):
    readme = " ".join(text(ROOT / "README.md").split())
    sentence, = re.findall(rf"{start} (.*?)\.(?: |$)", readme)
    told = re.findall(r"`((?:golden |hdl\.|sim\.)[a-z]+)`", sentence)
    taking = {f"{module} {command}" if module == "golden" else module for module, command, _ in commands(ROOT / "README.md")
              if f"[{option} " in help_of(module, command, capsys)}
    assert set(told) == taking and len(told) == len(taking)


def test_changelog_begins_with_this_version():
    """Below what is unreleased; newest first, each with its date."""
    version = tomllib.loads(text(ROOT / "pyproject.toml"))["project"]["version"]
    sections = re.findall(r"^## (.*)$", text(ROOT / "CHANGELOG.md"), re.MULTILINE)
    released = [re.fullmatch(r"(\d+\.\d+\.\d+) - (\d{4}-\d\d-\d\d)", each) for each in sections if each != "Unreleased"]
    assert all(released) and released[0][1] == version and sections.index(f"{version} - {released[0][2]}") <= 1
    assert sorted((each[2] for each in released), reverse=True) == [each[2] for each in released]


@pytest.mark.parametrize("path", CURRENT, ids=name)
def test_paths_exist(path):
    """What looks like a file or a folder of the repository is one."""
    spans = re.findall(r"`((?:golden|hdl|boards|sim|tests|docs)/[\w./-]*)`", text(path))
    assert [each for each in spans if not (ROOT / each).exists()] == []


def cells(path, row):
    """Cells of the row of a table that starts with these words."""
    found, = re.findall(rf"^\| {re.escape(row)}[^|]*\| (.*) \|$", text(path), re.MULTILINE)
    return found.split(" | ")


def test_readme_has_the_counts_of_the_pages():
    """Resources are those of docs/resources.md, generated, and of docs/tuning.md; the third figure of the latter is in a sentence."""
    size = "720x576x80"
    head = cells(ROOT / "docs" / "resources.md", "EP3C120")
    for row, generated, tuned in (("logic elements", "logic elements", "logic elements"), ("memory bits", "memory bits", "memory bits"),
                                  ("M9K blocks", "M9K", "M9K blocks")):
        thesis, sequential, streaming, fused, *_ = cells(ROOT / "README.md", row)
        counts = dict(zip(head, cells(ROOT / "docs" / "resources.md", generated), strict=True))
        sets = cells(ROOT / "docs" / "tuning.md", tuned)
        assert [thesis, sequential, streaming] == [counts[f"{name} {size}"] for name in ("thesis", "sequential", "streaming")]
        assert fused == sets[0]
        assert row == "memory bits" or f"{sets[2]} {row}" in " ".join(text(ROOT / "README.md").split())
