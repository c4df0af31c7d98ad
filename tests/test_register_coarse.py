"""A decimated template."""

import numpy as np
import pytest

from hilly_meshes import bent, hills
from mien.errors import BadInput
from mien.mesh import ClosestPoint, Mesh
from mien.register import (
    Template,
)


def test_a_template_that_cannot_be_decimated_is_refused():
    mesh = hills(61)
    fin = np.concatenate([mesh.vertices, mesh.vertices[:1] + 5])
    forked = Mesh(fin, np.concatenate([mesh.faces, [[*mesh.faces[700, :2], len(fin) - 1]]]))
    mixed = Mesh(mesh.vertices, np.where(np.arange(len(mesh.faces))[:, None] % 7, mesh.faces, mesh.faces[:, ::-1]))
    for wrong in (forked, mixed):
        with pytest.raises(BadInput, match="more than two triangles or mixed winding"):
            Template(wrong, coarse_vertices=500)
        Template(wrong, coarse_vertices=0)


def test_a_decimated_template_takes_the_stiff_rounds():
    fine = hills(61)
    target = fine.with_vertices(bent(fine.vertices))
    found = Template(fine, coarse_vertices=600).register(ClosestPoint(target))
    assert found.distances[found.accepted].mean() < 0.05
    assert found.rounds == 18
