"""Finished steps on disk: read where code and input are the same, made again where either changed."""

from dataclasses import dataclass

import numpy as np
import pytest

from mien import step_cache
from mien.mesh import Attachment, Mesh
from mien.step_cache import StepCache, fingerprint
from mien.transforms import Transform


@dataclass(frozen=True)
class Elsewhere:
    x: int


CALLS = []


def step(x, more=None):
    CALLS.append(x)
    mesh = Mesh(np.eye(3) * x, np.array([[0, 1, 2]]))
    return {"mesh": mesh, "T": (Transform.identity(2), None), "list": [1, 2.5, "name", True], "more": more}


@pytest.fixture
def cached(tmp_path):
    CALLS.clear()
    return StepCache(tmp_path / "work")


def test_results_come_back_as_they_were(cached):
    held = Attachment(np.array([0]), np.full((1, 3), 1 / 3))
    first, second = cached(step, x=2.0, more=held), cached(step, x=2.0, more=held)
    assert CALLS == [2.0]
    assert fingerprint(first) == fingerprint(second)
    assert isinstance(second["mesh"], Mesh)
    assert isinstance(second["T"], tuple)
    assert second["list"] == [1, 2.5, "name", True]
    np.testing.assert_array_equal(second["more"].barycentric, held.barycentric)


def test_other_input_other_code_and_broken_files_are_worked_out_anew(cached, monkeypatch):
    cached(step, x=1.0)
    cached(step, x=1.5)
    assert len(CALLS) == 2
    for kept in cached.folder.iterdir():
        kept.write_bytes(b"PK broken")
    cached(step, x=1.0)
    assert len(CALLS) == 3
    cached(step, x=1.0)
    assert len(CALLS) == 3
    monkeypatch.setattr(step_cache, "code_version", lambda: "the next release")
    cached(step, x=1.0)
    assert len(CALLS) == 4


@pytest.mark.parametrize("seed", range(40))
def test_a_store_that_is_damaged_anywhere_counts_as_none(cached, seed):
    """A few bytes changed, or the end cut off: what comes is what the step gives, never another error."""
    made, rng = cached(step, x=3.0), np.random.default_rng(seed)
    (kept,) = cached.folder.iterdir()
    data = bytearray(kept.read_bytes())
    for place in rng.integers(len(data), size=1 + seed % 5):
        data[place] = rng.integers(256)
    kept.write_bytes(data[: rng.integers(len(data))] if seed % 3 == 0 else data)
    again = cached(step, x=3.0)
    assert [3.0] * len(CALLS) == CALLS
    assert type(again) is type(made)


@pytest.mark.parametrize("tree", ["", "(", '{"array": "gone"}', '{"class": ["mien.gone", "Mesh"], "fields": {}}'])
def test_a_tree_that_leads_nowhere_counts_as_none(cached, tree):
    cached(step, x=3.0)
    (kept,) = cached.folder.iterdir()
    with kept.open("wb") as file:
        np.savez(file, tree=np.array(tree))
    assert fingerprint(cached(step, x=3.0)) == fingerprint(step(3.0))


def test_the_codes_version_is_that_of_its_sources(monkeypatch, tmp_path):
    package = tmp_path / "mien"
    (package / "cli").mkdir(parents=True)
    (package / "a.py").write_text("x = 1")
    monkeypatch.setattr(step_cache, "__file__", str(package / "step_cache.py"))
    version = step_cache.code_version.__wrapped__
    before = version()
    (package / "cli" / "verb.py").write_text("print()")
    assert version() == before
    (package / "a.py").write_text("x = 2")
    assert version() != before


def test_nothing_is_kept_without_a_folder():
    CALLS.clear()
    cached = StepCache()
    assert cached(step, x=3.0)["mesh"].vertices[0, 0] == 3.0
    cached(step, x=3.0)
    assert CALLS == [3.0, 3.0]


def test_steps_are_told_progress_and_loops_tell_theirs(tmp_path):
    seen = []

    class Watcher:
        def update(self, stage, done, total):
            seen.append((stage, done, total))

    def watched(x, progress):
        progress.update("inside", x, 9)
        return x

    assert StepCache(None, Watcher()).each("loop", watched, [{"x": 4}, {"x": 5}]) == [4, 5]
    assert seen == [("loop", 0, 2), ("inside", 4, 9), ("loop", 1, 2), ("inside", 5, 9), ("loop", 2, 2)]


def test_what_cannot_be_kept_or_told_apart_is_refused(cached):
    with pytest.raises(TypeError, match="cannot be kept"):
        cached(lambda: Elsewhere(1))
    with pytest.raises(TypeError, match="no fingerprint"):
        fingerprint([len])


def test_fingerprints_differ_where_inputs_do():
    seen = {fingerprint(x) for x in (1, 1.5, "1", (1,), (1, 2), np.ones(2), np.ones((2, 1)), np.zeros(2), None, {})}
    assert len(seen) == 10
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})
