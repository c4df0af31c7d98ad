"""What animates a face: by name, at the stage's rate, by the nodes above or by a joint."""

import numpy as np

from gltf_files import refusal
from mien.io import usd
from usd_files import foreign, performance


def test_an_animation_of_another_program(tmp_path):
    play = usd.read_performance(foreign(tmp_path / "a.usda"))
    assert play.rate == 24
    np.testing.assert_allclose(play.weights, [[0.5, 0, 0], [0.5, 0.25, 0], [1, 0.5, 0]])
    np.testing.assert_allclose(play.T_world_face.translation, [[0, 0, 0], [0, 20, 0], [0, 40, 0]], atol=1e-6)
    np.testing.assert_allclose(play.T_world_face.rotation, np.tile(np.eye(3), (3, 1, 1)), atol=1e-9)


def test_sparse_keys_are_filled_in_at_the_rate_of_the_stage(tmp_path):
    path = foreign(tmp_path / "a.usda", **{"2: [0.25, 0.5], ": ""})
    play = usd.read_performance(path)
    np.testing.assert_allclose(play.weights[1], [0.75, 0.25, 0])


def test_a_head_that_grows_is_told(tmp_path):
    scale = "float3 xformOp:scale.timeSamples = { 1: (1, 1, 1), 3: (2, 2, 2) }"
    order = "uniform token[] xformOpOrder = ["
    path = foreign(tmp_path / "a.usda", **{order: f'{scale}\n  {order}"xformOp:scale", '})
    assert "changes the head's size" in refusal(usd.read_performance, path)


def test_points_posed_by_usd_itself_are_ours(tmp_path):
    """USD's own skinning and blending of what is written, against the performance's meshes."""
    from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

    play = performance()
    usd.write_performance(tmp_path / "a.usdc", play)
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    root = UsdSkel.Root(stage.GetDefaultPrim())
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/face/mesh"))
    skinning = cache.GetSkinningQuery(mesh.GetPrim())
    skeleton = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/face/skeleton")))
    shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(mesh.GetPrim()))
    for t in (0, 7, len(play) - 1):
        weights = skeleton.GetAnimQuery().ComputeBlendShapeWeights(t)
        weights = skinning.GetBlendShapeMapper().Remap(weights)
        parts = shapes.ComputeSubShapeWeights(weights)
        points = Vt.Vec3fArray(mesh.GetPointsAttr().Get())
        rows, offsets = shapes.ComputeBlendShapePointIndices(), shapes.ComputeSubShapePointOffsets()
        shapes.ComputeDeformedPoints(*parts, rows, offsets, points)
        joints = skeleton.ComputeSkinningTransforms(t)
        skinning.ComputeSkinnedPoints(Vt.Matrix4dArray([Gf.Matrix4d(m) for m in joints]), points, t)
        ours = play.T_world_face[t].apply(play.rig.vertices(play.weights[t]))
        np.testing.assert_allclose(np.array(points) * 1000, ours, atol=1e-3)
