"""What files are, and which verbs take them."""

import numpy as np
import pytest

from gltf_files import performance, rig
from marker_files import take, wide_csv
from mesh_files import bumpy
from mien.cli import kinds
from mien.cli.kinds import hint, kind_of
from mien.cli.main import PIPELINE
from mien.io import usd
from mien.io.gltf import write_performance, write_rig
from mien.io.livelink import write_live_link
from mien.io.markers import READERS
from mien.io.meshes import write_mesh
from mien.io.performances import READ
from mien.rgbd import VIDEO_SUFFIXES
from mien.viewer import open_files, take_film
from test_io_rigs import folder_of

EVERY = [kind for kind in vars(kinds).values() if isinstance(kind, kinds.Kind)]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kinds")
    write_performance(folder / "perf.glb", performance(3))
    write_rig(folder / "rig.glb", rig())
    usd.write_performance(folder / "perf.usdc", performance(3))
    usd.write_rig(folder / "rig.usdc", rig())
    write_live_link(folder / "app.csv", performance(3))
    wide_csv(folder / "take.csv", take().positions)
    write_mesh(folder / "scan.ply", bumpy())
    folder_of(folder / "shapes", ".ply")
    (folder / "take" / "color").mkdir(parents=True)
    (folder / "light").mkdir()
    (folder / "light" / "calibration.json").touch()
    (folder / "pictures").mkdir()
    (folder / "pictures" / "0.PNG").touch()
    for name in ("film.MOV", "a.exr", "a.gesichter", "a.xyz", "b.r3d"):
        (folder / name).touch()
    return folder


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("perf.glb", kinds.PERFORMANCE),
        ("rig.glb", kinds.RIG),
        ("perf.usdc", kinds.PERFORMANCE),
        ("rig.usdc", kinds.RIG),
        ("app.csv", kinds.LIVE_LINK),
        ("take.csv", kinds.MARKERS),
        ("scan.ply", kinds.SCAN),
        ("shapes", kinds.SCANS_FOLDER),
        ("take", kinds.DEPTH_TAKE),
        ("light", kinds.LIGHT_TAKE),
        ("pictures", kinds.VIDEO),
        ("film.MOV", kinds.VIDEO),
        ("a.exr", kinds.MAP),
        ("a.gesichter", kinds.LIVE_LINK),
        ("b.r3d", kinds.DEPTH_TAKE),
        ("a.xyz", None),
    ],
)
def test_kinds(files, name, kind):
    assert kind_of(files / name) is kind


def test_a_hint_names_the_verb_that_wants_the_file(files):
    told = hint("solve", [str(files / "app.csv"), "-o", "x.glb"])
    assert told == (
        f"; {files / 'app.csv'} is a Live Link Face recording: `mien convert {files / 'app.csv'} -o perf.glb` "
        "(play it on the bundled face)"
    )
    assert hint("solve", [str(files / "take.csv")]) == ""
    assert hint("solve", ["none.csv"]) == ""
    assert "mien track" in hint("solve", [str(files / "film.MOV")])
    (files / "broken.glb").write_bytes(b"x")
    assert hint("solve", [str(files / "broken.glb")]) == ""


@pytest.mark.parametrize("kind", EVERY, ids=lambda kind: kind.what)
def test_commands_are_verbs_that_exist(kind):
    assert kind.verbs <= set(PIPELINE)
    assert np.all([command.startswith("mien ") for command, _ in kind.commands])


def test_suffixes_are_those_that_the_readers_take():
    """`kinds` names them itself, so that a command starts before readers are imported."""
    assert set(kinds.FILMS) == set(VIDEO_SUFFIXES) >= set(take_film.PLAYED)
    assert set(kinds.FACES) == set(READ)
    assert set(kinds.TABLES) | {".c3d", ".trc"} == set(READERS)


def test_the_page_takes_every_marker_file(tmp_path):
    wide_csv(tmp_path / "take.csv", take().positions)
    table = (tmp_path / "take.csv").read_text().replace(",", "\t")
    (tmp_path / "take.tsv").write_text(table)
    [shown], films = open_files.gather([tmp_path / "take.tsv"])
    assert not films
    np.testing.assert_allclose(shown.thing.positions, take().positions, atol=1e-3)
