from dataclasses import replace

import numpy as np
import pytest

from detail_patch import marker_places, patch, training
from mien.detail.base_mesh import BaseConfig
from mien.detail.domain import deformation_vectors
from mien.detail.fit import DetailConfig, fit_detail
from mien.detail.transfer.other_actor import OtherActor, carried_to
from mien.errors import BadInput
from mien.experiments.detail_stage import detail_errors

SMALL = DetailConfig(base=BaseConfig(vertices=0), medium_size=48, fine_size=96, high_pass_mm=4.0)


def other_person():
    """A larger patch with a ripple of its own at rest, that wrinkles as the trained one does."""
    mesh = patch()
    points = mesh.vertices * 1.08
    points[:, 2] += 0.15 * np.sin(2 * np.pi * points[:, 1] / 9.0)
    return mesh.with_vertices(points)


def test_wrinkles_on_another_face_beat_the_shell_and_its_own_static_map():
    model = fit_detail(training(), SMALL)
    neutral = other_person()
    places = marker_places(neutral).points(neutral)
    clips = training(mesh=neutral)
    actor = OtherActor(neutral, clips.markers)
    assert places.shape == actor.markers.shape
    made = carried_to(model, actor, SMALL)
    errors = detail_errors(made, replace(clips, clips=clips.clips[:1]), SMALL.base)["squeeze"]
    assert errors.full < 0.75 * errors.shell
    assert errors.full < errors.frozen
    assert np.isfinite(made.medium.polynomial.coefficients).all()
    rest = made.medium.driven.values(np.zeros((25, 5)))
    assert np.isfinite(rest).all()
    assert deformation_vectors(made.domain.strains, actor.markers[None]).max() == pytest.approx(0, abs=1e-9)


def test_other_markers_are_refused():
    model = fit_detail(training(), replace(SMALL, medium_size=16, fine_size=0))
    neutral = other_person()
    with pytest.raises(BadInput, match="the places of the model's 25"):
        carried_to(model, OtherActor(neutral, np.zeros((4, 3))), SMALL)
