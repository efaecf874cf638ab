"""The store of compiled models: whole files only, one build where two meet, a bound."""

import os
import subprocess
import sys
import time

import pytest

from sim.kit import store as module
from sim.kit.store import ROOT, Store, models


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "a" / "store")


def model(folder, content="model", mode=0o755):
    path = folder / "source"
    path.write_text(content)
    path.chmod(mode)
    return path


def names(store):
    return {path.name for path in store.folder.iterdir()}


def test_kept_file_is_copied(store, tmp_path):
    target = tmp_path / "target"
    assert not store.fetch("key", target) and not target.exists()
    store.keep("key", model(tmp_path))
    assert store.fetch("key", target)
    assert target.read_text() == "model" and os.access(target, os.X_OK)
    assert not store.fetch("other", target) and target.read_text() == "model"
    assert names(store) == {"key"}


def test_target_is_replaced_not_rewritten(store, tmp_path):
    """A simulator that runs the file goes on with what it has opened."""
    target = tmp_path / "target"
    target.write_text("before")
    store.keep("key", model(tmp_path))
    with target.open() as running:
        assert store.fetch("key", target)
        assert running.read() == "before" and target.read_text() == "model"


def test_least_recently_used_goes_first(tmp_path):
    store = Store(tmp_path / "store", limit=3000)
    source = model(tmp_path, 1000 * "x")
    for age, key in enumerate("abc"):
        store.keep(key, source)
        os.utime(store.folder / key, (age, age))
    assert store.fetch("a", tmp_path / "target")    # now the latest
    store.keep("d", source)
    assert names(store) == {"a", "c", "d"}
    with store.making("e"):
        assert names(store) == {"a", "c", "d", "lock"}
    store.keep("e", model(tmp_path, 2500 * "x"))
    assert names(store) == {"e", "lock"}


def test_store_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    store = Store(tmp_path / "file" / "store")
    with store.making("key"):
        store.keep("key", model(tmp_path))
    assert not store.fetch("key", tmp_path / "target")


def test_interrupted_copy_leaves_nothing(store, tmp_path, monkeypatch):
    def interrupted(source, target):
        target.write(b"mod")
        raise KeyboardInterrupt
    source = model(tmp_path)
    monkeypatch.setattr(module.shutil, "copyfileobj", interrupted)
    with pytest.raises(KeyboardInterrupt):
        store.keep("key", source)
    assert names(store) == set()


# Notes its turn in a file as it begins, as it ends; the file of the key is made by whoever finds none.
BUILDER = """
import pathlib, sys, time
from sim.kit.store import Store
store, work = Store(sys.argv[1]), pathlib.Path(sys.argv[2])
with store.making(sys.argv[3]):
    print("begin", flush=True)
    if not store.fetch(sys.argv[3], work):
        time.sleep(float(sys.argv[4]))
        work.write_text("model")
        store.keep(sys.argv[3], work)
        print("built", flush=True)
"""


def builder(store, work, key="key", seconds=0.3):
    return subprocess.Popen([sys.executable, "-c", BUILDER, store.folder, work, key, str(seconds)], cwd=ROOT, stdout=subprocess.PIPE,
                            text=True)


def test_two_builds_meet(store, tmp_path):
    """One builds, the other waits and finds it."""
    builders = [builder(store, tmp_path / name) for name in ("left", "right")]
    told = sorted(process.communicate(timeout=60)[0] for process in builders)
    assert told == ["begin\n", "begin\nbuilt\n"]
    assert {(tmp_path / name).read_text() for name in ("left", "right")} == {"model"}
    assert names(store) == {"key", "lock"}


def test_killed_build_is_waited_for_no_longer(store, tmp_path):
    first = builder(store, tmp_path / "left", seconds=600)
    assert first.stdout.readline() == "begin\n"
    second = builder(store, tmp_path / "right")
    other = builder(store, tmp_path / "other", key="another key")   # has nothing to wait for
    assert other.communicate(timeout=60)[0] == "begin\nbuilt\n"
    time.sleep(0.2)
    assert second.poll() is None
    first.kill()
    first.communicate()
    assert second.communicate(timeout=60)[0] == "begin\nbuilt\n"
    assert names(store) == {"key", "another key", "lock"}


def test_where_models_are(tmp_path, monkeypatch):
    """Below ``build``; where that cannot be, or where there is no project, in a temporary folder."""
    def folder(root):
        monkeypatch.setattr(module, "ROOT", root)
        models.cache_clear()
        try:
            return models().folder
        finally:
            models.cache_clear()
    installed, project, read_only = (tmp_path / name for name in ("installed", "project", "read_only"))
    for root in (installed, project, read_only):
        root.mkdir()
    for root in (project, read_only):
        (root / "pyproject.toml").touch()
    (read_only / "build").touch()
    assert folder(project) == project / "build" / "models"
    for root in (installed, read_only):
        before = sorted(root.iterdir())
        assert tmp_path not in folder(root).parents and folder(root).is_dir()
        assert sorted(root.iterdir()) == before
