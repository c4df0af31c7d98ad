"""Who wears the markers."""

import numpy as np

from marker_stage import held, region
from mien.faces import load_face
from mien.fitting.marker_identity import IdentityConfig, fit_identity, on_closest, on_skin, person
from mien.fitting.terms import surface_points
from mien.transforms import Transform


def test_known_places_pin_the_person_down():
    face = load_face()
    there = region()
    places = held()
    rng = np.random.default_rng(8)
    someone = person(face, 0.8 * rng.normal(size=len(face.identity.modes)))
    cloud = surface_points(someone, places, 3.0)
    firm = IdentityConfig(noise_mm=0.05, slide_mm=(0.05, 0.05), rounds=8)
    fit = fit_identity(cloud, face, there, Transform.identity(), places, config=firm)
    mask = face.regions["narrow"] > 0.5
    assert np.linalg.norm((fit.neutral.vertices - someone.vertices)[mask], axis=1).mean() < 0.6


def test_a_marker_beyond_the_face_is_put_on_the_skin_there():
    face = load_face()
    skin = np.flatnonzero(np.isin(face.rig.neutral.faces, face.parts["skin"]).all(axis=1))
    places = held()
    cloud = surface_points(face.rig.neutral, places, 2.0)
    far = face.rig.neutral.vertices[face.rig.neutral.faces[skin]].mean(axis=1)
    lowest = far[[np.argmin(far[:, 1])]]
    held_too = IdentityConfig(noise_mm=0.05, slide_mm=(0.05, 0.05), rounds=3)
    fit = fit_identity(cloud, face, region(), Transform.identity(), places, config=held_too)
    found = on_skin(on_closest(fit, np.r_[cloud, lowest], region()), np.r_[cloud, lowest], skin, beyond_mm=6.0)
    assert found.residuals[-1] < 3
    np.testing.assert_array_equal(found.attachment.faces[:-1], on_closest(fit, cloud, region()).attachment.faces)
