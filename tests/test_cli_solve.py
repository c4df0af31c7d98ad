"""`mien solve`, from file to file."""

import json

import numpy as np
import pytest

from marker_stage import staged_take
from mien.cli.main import main
from mien.clip import Markers
from mien.faces import load_face
from mien.io.gltf import read_performance
from mien.io.markers import write_c3d
from mien.mesh import Attachment


def run(capsys, *words: str) -> tuple[int, str]:
    """`mien WORDS`: exit status and what it said on stderr."""
    with pytest.raises(SystemExit) as exit:
        main(list(words))
    return exit.value.code or 0, capsys.readouterr().err


def test_solve_from_file_to_file_and_placed_by_hand(tmp_path, capsys):
    take = staged_take().markers
    write_c3d(tmp_path / "take.c3d", Markers(take.positions[:60], take.labels, take.rate))
    out = tmp_path / "perf.glb"
    places = tmp_path / "places.json"
    solve = ("solve", str(tmp_path / "take.c3d"), "-o")
    assert run(capsys, *solve, str(out), "--save-attach", str(places))[0] == 0
    performance = read_performance(out)
    assert performance.weights.shape == (60, 52)
    assert performance.rate == take.rate
    assert {p.name for p in tmp_path.iterdir()} == {"take.c3d", "perf.glb", "perf.png", "perf.html", "places.json"}
    assert set(json.loads(places.read_text())) == set(take.labels)
    again = tmp_path / "again.glb"
    assert run(capsys, *solve, str(again), "--attach", str(places), "--personalise-rounds", "0")[0] == 0
    assert np.abs(read_performance(again).weights - performance.weights).mean() < 0.1
    mixed_up = tmp_path / "mixed_up.json"
    mixed_up.write_text(json.dumps(mirrored(json.loads(places.read_text()))))
    status, error = run(capsys, *solve, str(tmp_path / "no.glb"), "--attach", str(mixed_up))
    assert status == 2
    assert "are left and right" in error
    assert not (tmp_path / "no.glb").exists()


def mirrored(places: dict[str, dict]) -> dict[str, dict]:
    """Each marker where its partner on the other side sits: left and right mixed up."""
    neutral = load_face().rig.neutral
    faces, barycentric = (np.array([place[key] for place in places.values()]) for key in ("face", "barycentric"))
    points = Attachment(faces, barycentric).points(neutral)
    across = np.linalg.norm(points[:, None] * [-1, 1, 1] - points[None], axis=2).argmin(axis=1)
    ordered = list(places.values())
    return {label: ordered[other] for label, other in zip(places, across, strict=True)}


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"not a c3d file at all", "take.c3d"),
        (b"", "take.c3d"),
    ],
)
def test_bad_takes_are_one_line_status_2_and_leave_nothing(tmp_path, capsys, content, says):
    (tmp_path / "take.c3d").write_bytes(content)
    status, error = run(capsys, "solve", str(tmp_path / "take.c3d"), "-o", str(tmp_path / "perf.glb"))
    assert status == 2
    assert says in error
    assert error.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["take.c3d"]


def test_a_folder_that_is_not_there_is_told_before_the_work(tmp_path, capsys):
    write_c3d(tmp_path / "take.c3d", staged_take().markers)
    status, error = run(capsys, "solve", str(tmp_path / "take.c3d"), "-o", str(tmp_path / "no/perf.glb"))
    assert status == 2
    assert "does not exist" in error
