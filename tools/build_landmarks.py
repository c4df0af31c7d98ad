"""Find MediaPipe's 478 landmarks on the bundled face: render it as many people with many faces, detect, lift, average.

    python tools/build_landmarks.py

Needs the extra `landmarks` and its model (`mien fetch landmarks`). Writes src/mien/faces/assets/landmarks.npz.

Every detection is carried by rays to triangles, and so to one pose of the average face with its mouth a little open
(there the lips do not touch, so that upper and lower lip cannot be mixed up). Averages are made there, mirrored, laid
on the margins of lids and lips where they belong there, and fixed on the nearest skin.
"""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from mien.faces.bundled import BundledFace, load_face
from mien.landmarks.detector import COUNT, GROUPS, FaceLandmarker
from mien.mesh import Attachment, ClosestPoint, Mesh, submesh, vertex_normals
from mien.pictures.raycast import RayCaster
from mien.pictures.render import Look, Renderer
from mien.pictures.view import View, frontal_camera

ASSET = Path(__file__).parent.parent / "src/mien/faces/assets/landmarks.npz"
PEOPLE = 8
SIZE = 512
VIEWS = [(0.0, 0.0), (-0.3, 0.0), (0.3, 0.0), (0.0, 0.2), (0.0, -0.15), (-0.5, 0.1), (0.5, 0.1)]
"""Yaw and pitch, radians."""
FACES = [
    {},
    {"jawOpen": 0.3},
    {"jawOpen": 0.6},
    {"jawOpen": 0.2, "mouthSmileLeft": 0.5, "mouthSmileRight": 0.5},
    {"jawOpen": 0.3, "eyeWideLeft": 0.6, "eyeWideRight": 0.6},
]
IRIS_MM, PUPIL_MM = 5.9, 2.0
INWARD = 0.04
"""Share of the way to the face's middle by which the outline, seen from the front, is moved onto the face."""
EYES = ("left", "right")
OPENINGS = {
    "eye_left": (263, 362, "left_lower_lid", "left_upper_lid"),
    "eye_right": (33, 133, "right_lower_lid", "right_upper_lid"),
    "lips_inner": (78, 308, "lower_lip", "upper_lip"),
}
"""Two corners and the two edges of each opening."""


def main() -> None:
    """Build, write, say how far the detections agree."""
    face = load_face()
    pose = face.rig.mesh(weights(face, {"jawOpen": 0.3}))
    points, spread, mirror = average(face, pose)
    points = (points + points[mirror] * [-1, 1, 1]) / 2
    for group in OPENINGS:
        points = on_edges(face, pose, points, group)
    points = (points + points[mirror] * [-1, 1, 1]) / 2
    attachment = symmetric(face, pose, fix(face, pose, points), mirror)
    np.savez_compressed(
        ASSET,
        faces=attachment.faces.astype(np.int32),
        barycentric=attachment.barycentric.astype(np.float32),
        mirror=mirror.astype(np.int16),
    )
    print(f"{ASSET}: median spread between views {np.median(spread):.2f} mm")
    for name, members in GROUPS.items():
        print(f"  {name:12} {np.median(spread[list(members)]):.2f} mm")


def weights(face: BundledFace, expression: dict[str, float]) -> np.ndarray:
    """Rig weights of named shapes."""
    w = np.zeros(len(face.rig.names))
    for name, value in expression.items():
        w[face.rig.index(name)] = value
    return w


def painted(face: BundledFace) -> Mesh:
    """The neutral with white eyes and dark irises, which the detector looks for."""
    mesh = face.rig.neutral
    colors = np.array(mesh.colors if mesh.colors is not None else np.tile([0.8, 0.66, 0.58], (len(mesh.vertices), 1)))
    for side in EYES:
        eye = face.parts[f"{side}_eye"]
        p = mesh.vertices[eye]
        off = np.linalg.norm(p[:, :2] - (p[:, :2].min(0) + p[:, :2].max(0)) / 2, axis=1)
        front = p[:, 2] > p[:, 2].mean()
        colors[eye] = 0.9
        colors[eye[front & (off < IRIS_MM)]] = [0.30, 0.20, 0.14]
        colors[eye[front & (off < PUPIL_MM)]] = 0.04
    return replace(mesh, colors=colors)


def average(face: BundledFace, pose: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Every landmark on `pose`, the median over people, expressions and views; its spread, mm; who mirrors whom."""
    renderer = Renderer(painted(face), Look(occlusion=0, softness=0.0))
    rng = np.random.default_rng(0)
    found = []
    with FaceLandmarker() as landmarker:
        mirror = pairs(landmarker, renderer, pose)
        for k in range(PEOPLE):
            person = face.person(rng.normal(size=24) * (0.7 if k else 0.0))
            for expression in FACES:
                mesh = person.mesh(weights(face, expression))
                found += [seen(landmarker, renderer, mesh, pose, *view) for view in VIEWS]
    stack = np.array([f for f in found if f is not None])
    median = np.nanmedian(stack, axis=0)
    return median, np.nanmedian(np.linalg.norm(stack - median, axis=2), axis=0), mirror


def seen(landmarker, renderer, mesh: Mesh, pose: Mesh, yaw: float, pitch: float) -> np.ndarray | None:
    """One picture's landmarks on `pose`, NaN where the ray misses or grazes."""
    frame = mesh.vertices[(mesh.vertices[:, 1] > -120) & (mesh.vertices[:, 2] > 0)]
    view = frontal_camera(mesh, SIZE, yaw, pitch, frame=frame)
    landmarks = landmarker.detect(renderer.draw(*view, vertices=mesh.vertices))
    if landmarks is None:
        return None
    outline = list(GROUPS["contour"])
    pixels = landmarks.points.copy()
    pixels[outline] += INWARD * (pixels[outline].mean(axis=0) - pixels[outline])
    hits, facing = cast(mesh, view, pixels)
    there = np.full((COUNT, 3), np.nan)
    there[hits.hit] = hits.attachment().points(pose)
    grazing = ~(facing > 0.35)
    grazing[outline] = bool(yaw or pitch)
    there[grazing] = np.nan
    return there


def cast(mesh: Mesh, view: View, pixels: np.ndarray):
    """Rays through pixels, and the cosine at which they meet the surface."""
    back = view.T_camera_face.inverse()
    directions = back.rotate(view.camera.rays(pixels))
    hits = RayCaster(mesh).cast(np.broadcast_to(back.translation, directions.shape), directions)
    normals = vertex_normals(mesh.vertices, mesh.faces)[mesh.faces[hits.faces]]
    normal = np.einsum("pc,pcd->pd", hits.barycentric, normals)
    return hits, -np.einsum("pd,pd->p", normal, directions) / np.linalg.norm(directions, axis=1)


def pairs(landmarker: FaceLandmarker, renderer: Renderer, pose: Mesh) -> np.ndarray:
    """Which landmark mirrors which, from one frontal picture of a symmetric face: the cheapest one-to-one match."""
    found = landmarker.detect(renderer.draw(*frontal_camera(pose, SIZE), vertices=pose.vertices))
    points = np.column_stack([found.points - [(SIZE - 1) / 2, 0], found.depth])
    cost = np.linalg.norm(points[:, None] - points[None] * [-1, 1, 1], axis=2) ** 2
    match = linear_sum_assignment(cost + cost.T)[1]
    if not (match[match] == np.arange(COUNT)).all():
        raise SystemExit("the landmarks do not pair up left and right")
    return match


def on_edges(face: BundledFace, pose: Mesh, points: np.ndarray, group: str) -> np.ndarray:
    """Lay a loop of landmarks on the two edges of its opening: each at its own share of the way between the corners."""
    first, last, lower, upper = OPENINGS[group]
    members = list(GROUPS[group])
    below = members[1 : members.index(last)]
    moved = points.copy()
    corners = points[first], points[last]
    for name, inside in ((lower, below), (upper, members[members.index(last) + 1 :])):
        edge = dense(pose.vertices[face.contours[name]])
        if edge[0] @ [1, 0, 0] > edge[-1] @ [1, 0, 0]:
            edge = edge[::-1]
        share = along(edge, edge[0], edge[-1])
        for i in inside:
            moved[i] = edge[np.argmin(np.abs(share - along(points[[i]], *sorted(corners, key=lambda p: p[0]))))]
    if group.startswith("eye"):
        edge = pose.vertices[face.contours[lower]]
        ends = edge[[np.argmin(edge[:, 0]), np.argmax(edge[:, 0])]]
        for i in (first, last):
            moved[i] = ends[np.linalg.norm(ends - points[i], axis=1).argmin()]
    return moved


def dense(line: np.ndarray) -> np.ndarray:
    """A polyline with 40 points a segment."""
    share = np.linspace(0, 1, 40, endpoint=False)[:, None]
    segments = [a + (b - a) * share for a, b in pairwise(line)]
    return np.concatenate([*segments, line[-1:]])


def along(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Share of the way from start to end, seen from the front."""
    chord = (end - start)[:2]
    return (points[:, :2] - start[:2]) @ chord / (chord @ chord)


def fix(face: BundledFace, pose: Mesh, points: np.ndarray) -> Attachment:
    """The nearest skin, or eyeball for the irises."""
    irises = {side: list(GROUPS[f"iris_{side}"]) for side in EYES}
    parts = {f"{side}_eye": members for side, members in irises.items()}
    parts["skin"] = np.setdiff1d(np.arange(COUNT), np.concatenate(list(irises.values())))
    triangles, barycentric = np.zeros(COUNT, np.int64), np.zeros((COUNT, 3))
    for part, members in parts.items():
        inside = np.isin(pose.faces, face.parts[part]).all(axis=1)
        found = ClosestPoint(submesh(pose, inside)[0]).query(points[members])
        triangles[members] = np.flatnonzero(inside)[found.faces]
        barycentric[members] = found.barycentric
    return Attachment(triangles, barycentric)


def symmetric(face: BundledFace, pose: Mesh, attachment: Attachment, mirror: np.ndarray) -> Attachment:
    """The subject's left side mirrored onto the right, triangle by triangle; the middle on the mirror plane."""
    number = {tuple(sorted(t)): k for k, t in enumerate(pose.faces.tolist())}
    triangles, barycentric = attachment.faces.copy(), attachment.barycentric.copy()
    x = attachment.points(pose)[:, 0]
    for i, j in enumerate(mirror):
        source = pose.faces[attachment.faces[i if x[i] > x[j] else j]]
        weight = attachment.barycentric[i if x[i] > x[j] else j]
        if i == j:
            source, weight = source, np.where(face.mirror[source] == source, weight, 0)
            weight = weight / weight.sum()
        elif x[i] < x[j]:
            source = face.mirror[source]
        triangles[i] = number[tuple(sorted(source.tolist()))]
        barycentric[i] = [weight[source == v].sum() for v in pose.faces[triangles[i]]]
    return Attachment(triangles, barycentric)


if __name__ == "__main__":
    main()
