"""The files around the code: continuous integration, hooks and documents name targets, modules, options and files that exist."""

import importlib
import importlib.util
import pathlib
import re

import pytest
import yaml


ROOT = pathlib.Path(__file__).parent.parent
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
HOOKS = ROOT / ".pre-commit-config.yaml"
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
# The changelog names what there was.
CURRENT = [path for path in DOCUMENTS if path.name != "CHANGELOG.md"]


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
    assert entries == {"ruff": {"style"}, "mypy": {"types"}}
    assert set.union(*entries.values()) <= phony_targets()
    for hook in hooks.values():
        assert hook["language"] == "system" and hook["pass_filenames"] is False
    recipes = text(ROOT / "Makefile")
    assert "-m ruff check --no-fix golden hdl boards sim tests\n" in recipes and "-m mypy\n" in recipes


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_links_lead_somewhere(path):
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text(path)) if "://" not in link]
    assert [link for link in links if link and not (path.parent / link).exists()] == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=name)
def test_tables_are_whole(path):
    """Every block of lines with bars starts with a head and a rule, and all its rows are as long: an empty line would cut it."""
    unfenced = re.sub(r"^```.*?^```", "", text(path), flags=re.MULTILINE | re.DOTALL)
    for block in re.findall(r"(?:^\|.*\n?)+", unfenced, re.MULTILINE):
        cells = [len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()]
        assert len(cells) > 2 and re.fullmatch(r"\|([ :-]+\|)+", block.splitlines()[1]), block
        assert len(set(cells)) == 1, block


@pytest.mark.parametrize("path", CURRENT, ids=name)
def test_targets_exist(path):
    code = " ".join(re.findall(r"`[^`]+`", text(path)))
    assert made(code) <= phony_targets()


@pytest.mark.parametrize("path", CURRENT, ids=name)
def test_modules_exist(path):
    modules = set(re.findall(r"python -m ((?:golden|hdl|boards|sim)[\w.]*)", text(path)))
    assert {module for module in modules if importlib.util.find_spec(module) is None} == set()


def commands():
    """Command lines of the documents that start with `python -m`, without comments: module, words."""
    lines = {line.strip() for path in CURRENT for line in re.findall(r"python -m ((?:golden|hdl|boards|sim)[^\n`#]*)", text(path))}
    for line in sorted(lines):
        module, *words = re.sub(r"[\[\]();,|]", " ", line).split()
        if any(word.startswith("--") for word in words):
            yield pytest.param(module, words, id=line)


@pytest.mark.parametrize("module, words", list(commands()))
def test_options_exist(module, words, capsys):
    arguments = [words[0]] if module == "golden" else []
    options = {word.partition("=")[0].rstrip(".:") for word in words if re.match("--[a-z]", word)}
    with pytest.raises(SystemExit):  # help ends so
        importlib.import_module(f"{module}.__main__" if module in ("golden", "hdl.resources") else module).main([*arguments, "--help"])
    known = set(re.findall(r"--[\w-]+", capsys.readouterr().out))
    assert options <= known
