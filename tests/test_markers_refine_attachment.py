"""Markers slid to where the skin moves as they do."""

import numpy as np

from marker_stage import held, region
from mien.faces import load_face
from mien.fitting.marker_identity import IdentityFit
from mien.markers.refine_attachment import RefineConfig, refine_attachment
from mien.mesh import Attachment
from mien.takes.marker_model import marker_model
from mien.transforms import Transform


def test_a_marker_laid_beside_its_place_finds_back_by_its_motion():
    face = load_face()
    rng = np.random.default_rng(0)
    model = marker_model(face.rig, held(), np.full(60, 3.0))
    W = np.clip(rng.normal(0.2, 0.3, size=(120, 52)), 0, 1)
    targets = model.points(W)
    centres = face.rig.neutral.vertices[face.rig.neutral.faces[region()]].mean(axis=1)
    true = held().points(face.rig.neutral)
    off = np.array([region()[np.argmin(np.abs(np.linalg.norm(centres - p, axis=1) - 5.0))] for p in true])
    laid = Attachment(off, np.full((60, 3), 1 / 3))
    fit = IdentityFit(np.zeros(0), face.rig.neutral, Transform.identity(), laid, 3.0, np.zeros(60))
    free = RefineConfig(along=0.0, out=0.0)
    used = np.ones((120, 60), bool)
    found = refine_attachment(face.rig, fit, region(), W, targets, used, model.neutral, free)
    before, after = (np.linalg.norm(a.points(face.rig.neutral) - true, axis=1) for a in (laid, found))
    assert np.median(after) < 0.35 * np.median(before)
