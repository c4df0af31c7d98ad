"""Who wears the markers."""

import numpy as np

from marker_stage import held, region
from mien.faces import load_face
from mien.fitting.marker_identity import IdentityConfig, fit_identity, person
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
