"""Alembic, read back by its own library."""

import numpy as np
import pytest

from gltf_files import performance
from mien.errors import BadInput
from mien.io.alembic import write_alembic


def face_of(path):
    from alembic3d import Abc, AbcGeom

    archive = Abc.IArchive(str(path))
    return archive, AbcGeom.IPolyMesh(archive.getTop(), "face").getSchema()


def sample_at(schema, seconds: float):
    from alembic3d import Abc

    return schema.getValue(Abc.ISampleSelector(seconds))


@pytest.mark.parametrize("world", [True, False])
def test_every_vertex_of_every_frame(tmp_path, world):
    play = performance(9)
    write_alembic(tmp_path / "a.abc", play, world)
    archive, schema = face_of(tmp_path / "a.abc")
    assert schema.getNumSamples() == 9
    for t, mesh in enumerate(play.meshes(world=world)):
        points = sample_at(schema, t / play.rate).getPositions()
        np.testing.assert_allclose(np.array([tuple(p) for p in points]) * 1000, mesh.vertices, atol=1e-4)
    clock = schema.getTimeSampling()
    np.testing.assert_allclose([clock.getSampleTime(t) for t in range(3)], np.arange(3) / play.rate)
    del schema, archive


def test_faces_are_clockwise_with_their_texture_coordinates(tmp_path):
    from alembic3d import Abc

    play = performance(2)
    write_alembic(tmp_path / "a.abc", play)
    archive, schema = face_of(tmp_path / "a.abc")
    mesh = play.rig.neutral
    stored = np.array(list(sample_at(schema, 0.0).getFaceIndices())).reshape(-1, 3)
    np.testing.assert_array_equal(stored[:, ::-1], mesh.faces)
    uv = schema.getUVsParam().getExpandedValue(Abc.ISampleSelector(0.0)).getVals()
    corners = np.array([tuple(each) for each in uv]).reshape(-1, 3, 2)
    np.testing.assert_allclose(corners[:, ::-1], mesh.uv[mesh.uv_faces], atol=1e-6)
    del schema, archive


def test_a_missing_folder_is_told(tmp_path):
    with pytest.raises(BadInput, match="does not exist"):
        write_alembic(tmp_path / "none" / "a.abc", performance(2))
