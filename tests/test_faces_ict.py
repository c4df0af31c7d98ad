"""ICT-FaceKit's folder as a rig source, on a small folder of the same form."""

import numpy as np
import pytest

import mien.faces.ict as ict
from mien.errors import BadInput
from mien.faces.arkit import ARKIT_NAMES
from mien.faces.ict import load_ict

N = 12
NEUTRAL = np.random.default_rng(5).normal(size=(N, 3))
QUADS = [(0, 1, 2, 3), (3, 2, 4, 5), (4, 5, 6, 7), (8, 9, 10, 11)]


def write(path, vertices):
    lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in vertices]
    path.write_text("\n".join(lines + ["f " + " ".join(f"{i + 1}" for i in quad) for quad in QUADS]) + "\n")


def stems():
    """The kit's expression files: ARKit's names with _L and _R, two shapes in halves, no tongueOut."""
    both = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")
    for name in ARKIT_NAMES:
        if name in ("browInnerUp", "cheekPuff"):
            yield from (name + "_L", name + "_R")
        elif name in both:
            yield name
        elif name != "tongueOut":
            yield name.replace("Left", "_L").replace("Right", "_R")


@pytest.fixture(scope="module")
def fields():
    rng = np.random.default_rng(6)
    return {stem: rng.normal(size=(N, 3)) for stem in [*stems(), "identity000", "identity001"]}


@pytest.fixture
def kit(tmp_path, fields, monkeypatch):
    monkeypatch.setattr(ict, "AREAS", {"full": 8, "narrow": 6})
    write(tmp_path / "generic_neutral_mesh.obj", NEUTRAL)
    write(tmp_path / "cheekRaiser_L.obj", NEUTRAL)
    for stem, field in fields.items():
        write(tmp_path / f"{stem}.obj", NEUTRAL + field)
    return tmp_path


def test_names_are_arkits_in_its_order_but_for_the_tongue(kit):
    rig, _ = load_ict(kit, "all")
    assert rig.names == tuple(name for name in ARKIT_NAMES if name != "tongueOut")


def test_centimetres_become_millimetres_and_quads_two_triangles(kit, fields):
    rig, space = load_ict(kit, "all")
    np.testing.assert_allclose(rig.neutral.vertices, 10 * NEUTRAL, atol=1e-6)
    assert len(rig.neutral.faces) == 2 * len(QUADS)
    np.testing.assert_allclose(rig.deltas[rig.index("jawOpen")], 10 * fields["jawOpen"], atol=1e-6)
    np.testing.assert_allclose(space.modes, 10 * np.stack([fields["identity000"], fields["identity001"]]), atol=1e-6)


def test_sides_and_halves_go_where_arkit_has_them(kit, fields):
    rig, _ = load_ict(kit, "all")
    for name, parts in {
        "mouthSmileLeft": ["mouthSmile_L"],
        "eyeBlinkRight": ["eyeBlink_R"],
        "mouthLeft": ["mouthLeft"],
        "jawRight": ["jawRight"],
        "browInnerUp": ["browInnerUp_L", "browInnerUp_R"],
        "cheekPuff": ["cheekPuff_L", "cheekPuff_R"],
    }.items():
        expected = 10 * sum(fields[part] for part in parts)
        np.testing.assert_allclose(rig.deltas[rig.index(name)], expected, atol=1e-6)


@pytest.mark.parametrize(("area", "vertices", "triangles"), [("full", 8, 6), ("narrow", 6, 4), ("all", 12, 8)])
def test_areas_are_the_first_vertices_and_what_lies_within(kit, area, vertices, triangles):
    rig, space = load_ict(kit, area)
    assert rig.neutral.vertices.shape == (vertices, 3)
    assert rig.neutral.faces.shape == (triangles, 3)
    assert rig.deltas.shape == (51, vertices, 3)
    assert space.modes.shape == (2, vertices, 3)


def test_the_kits_own_areas_are_those_of_its_readme():
    assert ict.AREAS == {"full": 9409, "narrow": 6706}


def test_progress_is_told_of_every_file(kit):
    told = []

    class Watch:
        def update(self, stage, done, total):
            told.append((done, total))

    load_ict(kit, "all", Watch())
    assert told == [(i + 1, 55) for i in range(55)]


def test_a_missing_neutral_is_named(tmp_path):
    with pytest.raises(BadInput, match=r"has no generic_neutral_mesh\.obj"):
        load_ict(tmp_path)


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(BadInput, match="nowhere"):
        load_ict(tmp_path / "nowhere")


def test_a_missing_expression_is_named(kit):
    (kit / "mouthSmile_L.obj").unlink()
    with pytest.raises(BadInput, match=r"has no mouthSmile_L\.obj"):
        load_ict(kit)


def test_a_kit_without_identities_is_refused(kit):
    for path in kit.glob("identity*"):
        path.unlink()
    with pytest.raises(BadInput, match=r"has no identity000\.obj"):
        load_ict(kit)


def test_another_vertex_count_names_the_file(kit):
    write(kit / "jawOpen.obj", np.concatenate([NEUTRAL, NEUTRAL[:1]]))
    with pytest.raises(BadInput, match=r"jawOpen\.obj: has 13 vertices, generic_neutral_mesh\.obj 12"):
        load_ict(kit)


def test_a_mesh_too_small_for_the_area_is_refused(kit, monkeypatch):
    monkeypatch.setattr(ict, "AREAS", {"full": 100, "narrow": 6})
    with pytest.raises(BadInput, match="has 12 vertices, the full face 100"):
        load_ict(kit)


def test_an_unknown_area_is_refused(kit):
    with pytest.raises(BadInput, match="full, narrow and all"):
        load_ict(kit, "ears")
