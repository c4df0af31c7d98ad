"""Blender shows what was written: vertices, names, rates, normals, a picture; and makes the FBX."""

import re
from pathlib import Path

import numpy as np
import pytest
from face import FRAMES, HERE, TOLERANCE_MM, Shown, off_mm, performance, run, turned_deg
from PIL import Image

from mien.io import usd
from mien.io.alembic import write_alembic
from mien.io.performances import write_any_performance

BLENDER = HERE.parent / ".venv-clients/bin/python"
PAGE = HERE.parent / "docs/exits.md"


def blender(path: Path) -> Shown:
    """A file through Blender, its picture beside it."""
    numbers = path.with_suffix(".npz")
    run(BLENDER, HERE / "blender_frames.py", path, 60, numbers, path.with_suffix(".png"), *map(str, FRAMES))
    read = np.load(numbers)
    points, normals = (read[key].astype(float) @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]] for key in ("points", "normals"))
    return Shown(points * 1000, normals, tuple(read["names"]), float(read["fps"]), tuple(read["range"].tolist()))


@pytest.fixture(scope="module")
def play():
    return performance()


@pytest.mark.parametrize("suffix", [".glb", ".usdc", ".usdz", ".abc"])
def test_blender_shows_every_vertex_where_it_is(tmp_path, play, suffix):
    path = tmp_path / f"face{suffix}"
    (write_alembic if suffix == ".abc" else write_any_performance)(path, play)
    shown = blender(path)
    off = off_mm(shown, play)
    turned = turned_deg(shown, play)
    print(f"{suffix}: {off:.1e} mm, normals {np.median(turned):.2f} degrees (95 %: {np.quantile(turned, 0.95):.2f})")
    assert off < TOLERANCE_MM
    if suffix != ".abc":
        assert shown.names == play.rig.names
    if suffix != ".glb":
        assert shown.frame_range == (0, 89)
    picture = np.asarray(Image.open(path.with_suffix(".png")).convert("L"), int)
    drawn = np.abs(picture - picture[0, 0]) > 20
    assert 0.03 < drawn.mean() < 0.9
    if suffix != ".abc":  # which has none of its own: Blender makes them, by another rule
        assert np.quantile(turned, 0.95) < 5


def test_blender_displaces_the_skin_by_millimetres(tmp_path, play):
    heights = np.random.default_rng(0).random((2, 16, 16)).astype(np.float32)
    usd.write_performance(tmp_path / "face.usdc", play, heights)
    asked = """
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath="face.usdc")
nodes = {node.type: node for node in bpy.data.materials["skin"].node_tree.nodes}
picture, moved = nodes["TEX_IMAGE"].image, nodes["DISPLACEMENT"]
print("FOUND", moved.inputs["Scale"].default_value, moved.inputs["Midlevel"].default_value, *list(picture.pixels)[::4])
"""
    (tmp_path / "asked.py").write_text(asked)
    [line] = [line for line in run(BLENDER, "asked.py", cwd=tmp_path).splitlines() if line.startswith("FOUND")]
    scale, middle, *pixels = map(float, line.split()[1:])
    shown = (np.array(pixels) - middle) * scale * 1000
    np.testing.assert_allclose(shown.reshape(16, 16)[::-1], heights[0], atol=1e-3)


def test_the_fbx_script_of_the_docs_makes_one(tmp_path, play):
    """The script as it stands in docs/exits.md, then its file read back by Blender."""
    [script] = re.findall(r"```python\n(# fbx.*?)```", PAGE.read_text(), re.S)
    write_any_performance(tmp_path / "perf.glb", play)
    (tmp_path / "fbx.py").write_text(script)
    run(BLENDER, "fbx.py", cwd=tmp_path)
    back = """
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.fbx(filepath="perf.fbx")
face = max((o for o in bpy.data.objects if o.type == "MESH"), key=lambda o: len(o.data.vertices))
print("SHAPES", *[key.name for key in face.data.shape_keys.key_blocks[1:]])
"""
    (tmp_path / "back.py").write_text(back)
    [line] = [line for line in run(BLENDER, "back.py", cwd=tmp_path).splitlines() if line.startswith("SHAPES")]
    assert tuple(line.split()[1:]) == play.rig.names
