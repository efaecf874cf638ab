"""golden.lab.cache: found again by content, and only by that."""

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass
from golden.errors import UserError
from golden.lab import cache as cache_module
from golden.lab.cache import Cache, source_digest, source_files
from golden.matcher.labelling import match
from golden.matcher.matcher import disparities


pytest.importorskip("dask", reason="dask, of the extra lab, is not installed")


LEFT, RIGHT = np.random.default_rng(1).integers(0, 256, (2, 5, 6))
JOB = (match, LEFT, RIGHT, MatcherConfig(labels=4))


def test_what_is_kept_is_found(tmp_path):
    cache = Cache(tmp_path / "a" / "b")
    assert cache.load(JOB) is None
    result = {"labels": np.arange(6).reshape(2, 3), "seconds": np.array(0.5)}
    cache.keep(JOB, result)
    for again in (cache, Cache(tmp_path / "a" / "b")):
        found = again.load((match, LEFT.copy(), RIGHT.copy(), MatcherConfig(labels=4)))
        assert found.keys() == result.keys()
        for name, array in result.items():
            np.testing.assert_array_equal(found[name], array)


def test_whatever_differs_is_another_job(tmp_path, monkeypatch):
    cache = Cache(tmp_path)
    changed = LEFT.copy()
    changed[4, 5] += 1
    others = [(disparities, *JOB[1:]), (match, changed, *JOB[2:]), (match, RIGHT, LEFT, JOB[3]), (*JOB[:3], MatcherConfig(labels=5)),
              (*JOB[:3], MatcherConfig(labels=4, method=OnePass("linear"))), (match, LEFT.astype(np.int32), *JOB[2:])]
    paths = {cache.path(job) for job in (JOB, *others)}
    assert len(paths) == len(others) + 1
    monkeypatch.setattr(cache_module, "_sources", lambda file: f"other code in {file}")
    assert cache.path(JOB) not in paths


@pytest.mark.parametrize("content", [b"", b"damaged", b"PK\x03\x04 damaged"])
def test_a_damaged_file_is_no_result(tmp_path, content):
    cache = Cache(tmp_path)
    cache.path(JOB).write_bytes(content)
    assert cache.load(JOB) is None


def test_a_file_in_the_way(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match=r"cannot make the folder .*file/below.* choose another --cache"):
        Cache(tmp_path / "file" / "below").keep(JOB, {})


def test_sources(tmp_path):
    files = {
        "a.py": "from .b import x\nimport os\nfrom . import c, nothing",
        "b.py": "def f():\n    from .below.d import y\nfrom os import path",
        "c.py": "from .a import z", "other.py": "from . import a", "below/__init__.py": "", "e.py": "", "below/f.py": "", "below/g.py": "",
        "below/d.py": "from ..e import w\nfrom . import g"}
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)

    def names(start):
        return {path.relative_to(tmp_path.resolve()).as_posix() for path in source_files(tmp_path / start)}

    assert names("a.py") == set(files) - {"other.py", "below/f.py"}
    assert names("below/g.py") == {"below/g.py"}
    (tmp_path / "h.py").write_text("from .below import f")
    assert names("h.py") == {"h.py", "below/__init__.py", "below/f.py"}


def test_sources_of_a_job_are_those_of_its_module():
    file = match.__code__.co_filename
    assert cache_module._sources(file) == source_digest(source_files(file))


def test_digest(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("a = 1")
    two.write_text('"""Words."""\n\nclass C:\n    """Words."""\n    def f(self):\n        """Words."""\n        return 1')
    first = source_digest([one, two])
    assert first == source_digest([two, one]) != source_digest([one])
    two.write_text("class C:\n    # Other words.\n    def f(self):\n        'Other words.'\n        return (1)")
    assert source_digest([one, two]) == first
    digests = {first}
    for value in ("2", "'Words.'", "'Other words.'"):
        two.write_text(f"class C:\n    def f(self):\n        return {value}")
        digests.add(source_digest([one, two]))
    assert len(digests) == 4
