import json
from pathlib import Path

import numpy as np
import pytest

from command import mien
from face_model import needs_model
from mien.errors import BadInput
from mien.faces.bundled import load_face
from mien.faces.scan_clean import cleaned, mended, outward, welded, wound_alike
from mien.fitting.register_scan import RegisterConfig, register_scan, registered_rig
from mien.io.gltf import read_rig
from mien.io.meshes import read_scan, write_mesh
from mien.landmarks.brow_edges import BROW_EDGES
from mien.landmarks.detector import bundled_landmarks
from mien.landmarks.lift import LiftConfig, lift_landmarks
from mien.mesh import Mesh, Scan, loop_subdivide, submesh, vertex_normals
from mien.reports.single_scan import registration_record
from mien.transforms import Transform, rotation_from_vector

DATA = Path(__file__).parents[2] / "shared" / "data"


QUICK = RegisterConfig(lift=LiftConfig(sweep_pixels=256, pixels=480, views=((0.0, 0.0), (-0.25, 0.0), (0.25, 0.0))))


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    """Somebody with the mouth open: subdivided, cut at ears and neck, in metres and turned; the true face."""
    face = load_face()
    person = face.person(np.random.default_rng(8).normal(size=30) * 0.8)
    weights = np.zeros(len(person.names))
    weights[person.index("jawOpen")] = 0.4
    truth = person.vertices(weights)
    on_skin = np.isin(face.rig.neutral.faces, face.parts["skin"]).all(axis=1)
    skin, _ = submesh(person.neutral.with_vertices(truth), on_skin)
    fine, _ = loop_subdivide(skin)
    front, _ = submesh(fine, fine.vertices[fine.faces, 2].min(axis=1) > 0)
    T = Transform(rotation_from_vector(np.array([0.2, 0.5, 0.1])), np.array([0.4, 0.2, -0.3]), 0.001)
    path = tmp_path_factory.mktemp("scan") / "somebody.ply"
    write_mesh(path, front.with_vertices(T.apply(front.vertices)))
    return path, truth, T


@pytest.fixture(scope="module")
def found(staged):
    return register_scan(read_scan(staged[0]), config=QUICK)


@needs_model
def test_the_template_comes_to_lie_on_the_scan(found, staged):
    _, truth, T = staged
    face = load_face()
    assert found.landmarks.unit == "m"
    error = found.regions["face"]
    assert error.mean < 0.1
    assert error.p95 < 0.3
    assert error.covered > 0.85
    off = np.linalg.norm(found.mesh.vertices - (found.T_face_scan @ T).apply(truth), axis=1)
    assert off[face.regions["face"] > 0.5].mean() < 2.0
    assert found.expression["jawOpen"] > 0.2


@needs_model
def test_lids_and_lips_land_on_lids_and_lips(found, staged):
    _, truth, T = staged
    there = (found.T_face_scan @ T).apply(truth)
    for name, edge in load_face().contours.items():
        assert np.linalg.norm(found.mesh.vertices[edge] - there[edge], axis=1).mean() < 2.5, name


@needs_model
def test_hidden_parts_come_along(found, staged):
    """Eyeballs keep their size and stay behind the lids; the mouth's lining stays behind the skin."""
    face = load_face()
    for side in ("left", "right"):
        ball = face.parts[f"{side}_eye"]
        size = np.ptp(found.mesh.vertices[ball], axis=0)
        assert (np.abs(size - np.ptp(face.rig.neutral.vertices[ball], axis=0)) < 4).all()
    _, truth, T = staged
    off = np.linalg.norm(found.mesh.vertices - (found.T_face_scan @ T).apply(truth), axis=1)
    for part in ("upper_teeth", "lower_teeth", "tongue"):
        assert off[face.parts[part]].mean() < 6, part


@needs_model
def test_density_keeps_the_coarse_vertices_first(found, staged):
    fine = register_scan(read_scan(staged[0]), landmarks=found.landmarks, config=RegisterConfig(density=1))
    n = len(found.mesh.vertices)
    face = load_face().regions["face"] > 0.5
    assert len(fine.mesh.faces) == 4 * len(found.mesh.faces)
    assert np.linalg.norm(fine.mesh.vertices[:n] - found.mesh.vertices, axis=1)[face].mean() < 1.0
    assert fine.regions["face"].p95 <= found.regions["face"].p95 + 0.02
    rig = registered_rig(fine, load_face())
    assert rig.deltas.shape == (52, len(fine.mesh.vertices), 3)


@needs_model
def test_the_command_writes_face_page_and_record(staged, tmp_path, capsys, monkeypatch, found):
    monkeypatch.setattr("mien.fitting.register_scan.register_scan", lambda *_, **__: found)
    mien("register", staged[0], output=tmp_path / "face.glb", report=tmp_path / "page.html")
    assert "mean distance" in capsys.readouterr().out
    assert read_rig(tmp_path / "face.glb").names == load_face().rig.names
    record = json.loads((tmp_path / "page.register.json").read_text())["somebody"]
    assert record == json.loads(json.dumps(registration_record(found)))
    assert record["unit"] == "m"
    assert (tmp_path / "page.html").read_text().count("<img") == 1


def test_the_command_refuses_what_it_cannot_do(tmp_path):
    with pytest.raises(BadInput, match="a folder"):
        mien("register", tmp_path)
    with pytest.raises(BadInput, match=r"\.glb"):
        mien("register", tmp_path, output=tmp_path / "face.obj")
    with pytest.raises(BadInput, match="no such file"):
        mien("register", tmp_path / "scan.obj")


def ball() -> Mesh:
    mesh = load_face().rig.neutral
    return submesh(mesh, np.isin(mesh.faces, load_face().parts["left_eye"]).all(axis=1))[0]


def test_duplicated_vertices_are_welded_and_flat_triangles_go():
    mesh = ball()
    soup = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3))
    faces = np.concatenate([soup.faces, soup.faces[:5], [[0, 0, 1]]])
    clean = welded(Mesh(soup.vertices, faces))
    assert len(clean.vertices) == len(np.unique(np.round(mesh.vertices, 6), axis=0))
    assert len(clean.faces) <= len(mesh.faces)


@pytest.mark.parametrize("wrong", ["none", "all", "some"])
def test_normals_are_turned_outward(wrong):
    mesh = welded(ball())
    faces = mesh.faces.copy()
    flip = {"none": np.zeros(len(faces), bool), "all": np.ones(len(faces), bool),
            "some": np.random.default_rng(0).random(len(faces)) < 0.3}[wrong]  # fmt: skip
    faces[flip] = faces[flip, ::-1]
    right = outward(Mesh(mesh.vertices, faces))
    out = mesh.vertices - mesh.vertices.mean(axis=0)
    assert (np.einsum("nd,nd->n", vertex_normals(right.vertices, right.faces), out) > 0).mean() > 0.98


def test_winding_is_mended_and_texture_stays_on_its_corners():
    mesh = load_face().rig.neutral
    flip = np.random.default_rng(1).random(len(mesh.faces)) < 0.5
    mixed = Mesh(
        mesh.vertices,
        np.where(flip[:, None], mesh.faces[:, ::-1], mesh.faces),
        mesh.uv,
        np.where(flip[:, None], mesh.uv_faces[:, ::-1], mesh.uv_faces),
    )
    mended = wound_alike(mixed)
    right = np.sort(mended.faces, axis=1)
    np.testing.assert_array_equal(right, np.sort(mesh.faces, axis=1))
    at = {(int(v), int(t)) for v, t in zip(mesh.faces.ravel(), mesh.uv_faces.ravel(), strict=True)}
    assert {(int(v), int(t)) for v, t in zip(mended.faces.ravel(), mended.uv_faces.ravel(), strict=True)} == at
    normals, true = (vertex_normals(m.vertices, m.faces) for m in (mended, mesh))
    np.testing.assert_allclose(np.abs(np.einsum("nd,nd->n", normals, true)), 1, atol=1e-9)


def test_non_manifold_edges_do_no_harm():
    mesh = welded(ball())
    fin = np.concatenate([mesh.vertices, mesh.vertices[[0]] + 5.0])
    faces = np.concatenate([mesh.faces, [[*mesh.faces[0, :2], len(mesh.vertices)]]])
    assert len(cleaned(Mesh(fin, faces)).faces) == len(faces)


def test_what_was_mended_is_told():
    mesh = welded(ball())
    assert mended(mesh)[1] == ()
    soup = np.concatenate([mesh.faces[:, ::-1], mesh.faces[:1, ::-1]])
    broken = Mesh(mesh.vertices[soup].reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
    clean, notes = mended(broken)
    assert len(clean.vertices) == len(mesh.vertices)
    assert [line.split()[0] for line in notes] == [str(3 * len(soup) - len(mesh.vertices)), "1", str(len(mesh.faces))]
    assert "twins" in notes[0]
    assert "inner side" in notes[2]
    fin = Mesh(np.concatenate([mesh.vertices, mesh.vertices[:1] * 1.2]),
               np.concatenate([mesh.faces, [[*mesh.faces[0, :2], len(mesh.vertices)]]]))  # fmt: skip
    assert any(note.startswith("1 edges of more than two triangles") for note in mended(fin)[1])


@needs_model
def test_a_scan_with_faults_is_registered_all_the_same(found, staged):
    """Triangle soup, inside out, with a fin on an edge: the same face, and the faults told."""
    scan = read_scan(staged[0])
    mesh, fin = scan.mesh, scan.mesh.vertices[:1] + 0.001
    faces = np.concatenate([mesh.faces[:, ::-1], [[*mesh.faces[0, :2], len(mesh.vertices)]]])
    soup = np.concatenate([mesh.vertices, fin])[faces].reshape(-1, 3)
    colors = np.concatenate([mesh.colors, mesh.colors[:1]])[faces].reshape(-1, 3)
    broken = Scan(Mesh(soup, np.arange(len(soup)).reshape(-1, 3), colors=colors), name="broken")
    again = register_scan(broken, landmarks=found.landmarks, config=QUICK)
    np.testing.assert_allclose(again.mesh.vertices, found.mesh.vertices, atol=0.2)
    assert len(again.mended) == 3
    assert registration_record(again)["mended"] == list(again.mended)
    assert found.mended == ()


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3), int), "scan: is empty"),
        (np.ones((4, 3)), np.zeros((0, 3), int), "4 points but no triangles"),
        (np.array([[0.0, 0, 0], [1, 0, 0], [0, np.nan, 0]]), np.array([[0, 1, 2]]), "1 vertices are not finite"),
    ],
)
def test_what_is_no_surface_is_refused(vertices, faces, says):
    scan = Scan(Mesh(vertices, faces))
    for refuses in (register_scan, lift_landmarks):
        with pytest.raises(BadInput, match=says):
            refuses(scan)


def polyline(corners):
    """Many points along it."""
    at, between = np.arange(len(corners)), np.linspace(0, len(corners) - 1, 100)
    return np.stack([np.interp(between, at, axis) for axis in corners.T], axis=1)


@pytest.mark.data
@needs_model
@pytest.mark.skipif(not (DATA / "james").is_dir(), reason="the real scans are not here")
def test_a_real_scan_without_hints():
    """Lids and lips of a photographed head, against landmarks that people set on it."""
    found = register_scan(read_scan(DATA / "james" / "james.obj"))
    groups = json.loads((DATA / "james" / "james.ljson").read_text())["groups"]
    points = np.array(groups["LJSON"]["landmarks"]["points"])
    ours = bundled_landmarks().attachment.points(found.mesh)
    eyes = [33, 160, 158, 133, 153, 144, 362, 385, 387, 263, 373, 380]
    lips = [61, 40, 37, 0, 267, 270, 291, 321, 314, 17, 84, 91, 78, 81, 13, 311, 308, 402, 14, 178]
    theirs = found.T_face_scan.apply(points.astype(float))
    off = np.linalg.norm(ours[eyes + lips] - theirs[[*range(17, 29), *range(48, 68)]], axis=1)
    brows = np.concatenate([polyline(ours[list(line)]) for line in BROW_EDGES])
    above_the_eyes = theirs[[30, 31, 32, 44, 45, 46]]
    over = np.linalg.norm(above_the_eyes[:, None] - brows, axis=2).min(axis=1)
    assert found.landmarks.unit == "mm"
    assert off.mean() < 2.6
    assert over.mean() < 2.0
    assert found.regions["face"].mean < 0.1
    assert found.regions["face"].p95 < 0.3
