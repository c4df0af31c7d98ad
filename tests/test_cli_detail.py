import numpy as np
import pytest

from detail_patch import bent, patch, write_clips
from mien.cli.main import main
from mien.clip import Markers
from mien.io import usd
from mien.io.exr import read_exr
from mien.io.markers.c3d import write_c3d
from mien.io.meshes.ply import read_ply
from mien.rig import Performance, Rig
from mien.transforms import Transform

FIT = ["--base.vertices", "0", "--medium-size", "24", "--fine-size", "32"]


def run(*words):
    with pytest.raises(SystemExit) as stop:
        main(["detail", *map(str, words)])
    return stop.value.code or 0


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("detail")
    whole = write_clips(folder / "clips")
    strange = tuple(f"X{i}" for i in range(25))
    write_c3d(folder / "strange.c3d", Markers(whole.clips[0].markers, strange, 30.0))
    assert run("fit", folder / "clips", "-o", folder / "maps", *FIT) == 0
    return folder


def test_fit_then_synth_gives_a_mesh_a_frame(fitted, capsys):
    out = fitted / "out"
    take = fitted / "clips" / "squeeze" / "markers.c3d"
    assert run("synth", take, "--maps", fitted / "maps", "-o", out, "--levels", 0) == 0
    assert "8 frames of 1,089 vertices" in capsys.readouterr().out
    first, last = (read_ply(out / f"frame_{i:06d}.ply")[0] for i in (0, 7))
    truth = read_ply(fitted / "clips" / "squeeze" / "frame_000007.ply")[0]
    assert np.ptp(last.vertices[:, 0]) < 0.9 * np.ptp(first.vertices[:, 0])
    inner = (np.abs(truth.vertices[:, :2]) < 20).all(axis=1)
    off = np.linalg.norm(last.vertices[:, None] - truth.vertices[None, inner][:, ::40], axis=2).min(axis=0)
    assert off.mean() < 0.8


def test_coloured_clips_give_coloured_frames_without_their_dots_and_the_fine_map_as_pictures(tmp_path, capsys):
    write_clips(tmp_path / "clips", colors=True)
    dots = ["--reflectance.dot-radius-mm", 5]
    assert run("fit", tmp_path / "clips", "-o", tmp_path / "maps", *FIT, *dots) == 0
    assert "albedo 0.00" in capsys.readouterr().out
    take = tmp_path / "clips" / "squeeze" / "markers.c3d"
    assert run("synth", take, "--maps", tmp_path / "maps", "-o", tmp_path / "out", "--levels", 0, "--fine-map") == 0
    first, last = (read_ply(tmp_path / "out" / f"frame_{i:06d}.ply")[0].colors for i in (0, 7))
    assert first[:, 1].min() > 0.6
    assert np.median(last[:, 0]) > np.median(first[:, 0]) + 0.1
    assert read_exr(tmp_path / "out" / "fine_000007.exr")["height"].shape == (32, 32)
    assert (tmp_path / "out" / "normal_000007.png").is_file()


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["synth", "{clips}/squeeze/markers.c3d"], "--maps is missing"),
        (["synth", "{clips}/squeeze/markers.c3d", "--maps", "{clips}"], "no detail.json"),
        (["fit", "{clips}", "--maps", "x"], "--maps does nothing with fit"),
        (["synth", "{clips}/squeeze/markers.c3d", "--maps", "{maps}", "--half"], "--half does nothing with synth"),
        (["fit", "{maps}"], "no clips in it"),
        (["synth", "{clips}/../strange.c3d", "--maps", "{maps}"], "0 of the 25 markers that the maps were trained on"),
        (["view", "{clips}/../strange.c3d", "--maps", "{maps}"], "0 of the 25 markers that the maps were trained on"),
    ],
)
def test_bad_input_is_one_line(fitted, capsys, tmp_path, words, line):
    filled = [word.format(clips=fitted / "clips", maps=fitted / "maps") for word in words]
    assert run(*filled, "-o", tmp_path / "out") == 2
    told = capsys.readouterr().err
    assert line in told
    assert told.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_view_leaves_a_page(fitted, capsys):
    take = fitted / "clips" / "squeeze" / "markers.c3d"
    assert run("view", take, "--maps", fitted / "maps", "-o", fitted / "page") == 0
    assert "8 frames" in capsys.readouterr().out
    assert (fitted / "page" / "index.html").is_file()


def test_a_performance_takes_its_pores_along_as_displacement(fitted, capsys):
    mesh = patch(21)
    squeezed = bent(mesh.vertices, 0.2, 0) - mesh.vertices
    rig = Rig(mesh, squeezed[None], ("squeeze",))
    weights = np.linspace(0, 1, 3)[:, None]
    played = Performance(rig, weights, Transform.identity(3), 30.0, np.ones(3, bool))
    usd.write_performance(fitted / "perf.usdc", played)
    words = ["synth", fitted / "perf.usdc", "--maps", fitted / "maps", "--levels", 0, "--fine-map"]
    assert run(*words, "-o", fitted / "skin.usdc") == 0
    assert "a displacement map a frame" in capsys.readouterr().out
    heights = np.stack(list(usd.read_displacement(fitted / "skin.usdc")))
    assert heights.shape == (3, 32, 32)
    assert np.abs(heights[2] - heights[0]).max() > 1e-3
    assert run(*words, "-o", fitted / "skin.glb") == 2
    assert "glTF knows no displacement maps" in capsys.readouterr().err
