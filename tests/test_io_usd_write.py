"""What stands in a file: units, axes, rate, normals, a name for every shape."""

import numpy as np

from mien.io import usd
from mien.mesh import vertex_normals
from usd_files import NAMES, performance, rig


def stage_of(path):
    from pxr import Usd

    return Usd.Stage.Open(str(path))


def test_the_stage_says_how_it_is_to_be_read(tmp_path):
    from pxr import UsdGeom

    play = performance(rate=48.0)
    usd.write_performance(tmp_path / "a.usda", play)
    stage = stage_of(tmp_path / "a.usda")
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert (stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (48, 0, len(play) - 1)
    low, high = np.array(UsdGeom.Mesh(stage.GetPrimAtPath("/face/mesh")).GetExtentAttr().Get())
    np.testing.assert_allclose(low * 1000, play.rig.neutral.vertices.min(axis=0), atol=1e-4)
    low, high = np.array(UsdGeom.Boundable(stage.GetDefaultPrim()).GetExtentAttr().Get()) * 1000
    for mesh in play.meshes(world=True):
        assert (mesh.vertices >= low - 1e-3).all()
        assert (mesh.vertices <= high + 1e-3).all()


def test_normals_and_names_of_every_shape(tmp_path):
    from pxr import UsdGeom, UsdSkel

    usd.write_rig(tmp_path / "a.usdc", rig())
    stage = stage_of(tmp_path / "a.usdc")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/face/mesh"))
    binding = UsdSkel.BindingAPI(mesh.GetPrim())
    assert tuple(binding.GetBlendShapesAttr().Get()) == NAMES
    normals = np.array(mesh.GetNormalsAttr().Get())
    for k, target in enumerate(binding.GetBlendShapeTargetsRel().GetTargets()):
        shape = UsdSkel.BlendShape(stage.GetPrimAtPath(target))
        rows = np.array(shape.GetPointIndicesAttr().Get())
        assert len(rows) > 0  # Blender drops a shape without offsets
        turned = normals.copy()
        turned[rows] += np.array(shape.GetNormalOffsetsAttr().Get())
        true = vertex_normals(rig().neutral.vertices + rig().deltas[k], rig().neutral.faces)
        used = np.unique(rig().neutral.faces)
        np.testing.assert_allclose(turned[used], true[used], atol=3e-4)


def test_a_texture_lies_beside(tmp_path):
    usd.write_rig(tmp_path / "me.usd", rig())
    assert sorted(file.name for file in tmp_path.iterdir()) == ["me.base_color.png", "me.usd"]
    usd.write_rig(tmp_path / "you.usdz", rig())
    assert not (tmp_path / "you.base_color.png").exists()
