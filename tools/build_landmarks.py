"""Find MediaPipe's 478 landmarks on the bundled face: render it as many people with many faces, detect, lift, average.

    python tools/build_landmarks.py

Needs the extra `landmarks` and its model (`mien fetch landmarks`). Writes src/mien/faces/assets/landmarks.npz.

Every detection is carried by rays to triangles, and so to one pose of the average face with its mouth a little open
(there the lips do not touch, so that upper and lower lip cannot be mixed up). Averages are made there, mirrored, laid
on the margins of lids and lips where they belong there, and fixed on the nearest skin.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from mien.faces.bundled import BundledFace, load_face
from mien.faces.landmarks import COUNT, GROUPS, FaceLandmarker
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
AJAR, LEDGE_MM = 0.15, 0.6
"""How far the jaw opens to show the lips' rims, and the step in depth that ends a lip, mm a pixel."""
CORNERS = (78, 308)
EYES = {"left": (263, 362), "right": (33, 133)}
"""Outer and inner corner."""


def main() -> None:
    """Build, write, say how far the detections agree."""
    face = load_face()
    pose = face.rig.mesh(weights(face, {"jawOpen": 0.3}))
    points, spread, mirror = average(face, pose)
    points = (points + points[mirror] * [-1, 1, 1]) / 2
    for side in EYES:
        points = on_margin(points, f"eye_{side}", margin(face, pose, side))
    points = on_rims(face, pose, points)
    points = (points + points[mirror] * [-1, 1, 1]) / 2
    attachment = fix(face, pose, points)
    points = attachment.points(pose)
    right, middle = points[:, 0] < points[mirror, 0], mirror == np.arange(COUNT)
    points[right] = points[mirror[right]] * [-1, 1, 1]
    points[middle] = on_midline(face, pose, points[middle])
    attachment = fix(face, pose, points)
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


def margin(face: BundledFace, pose: Mesh, side: str) -> np.ndarray:
    """The lids' margin (k, 3): skin where, seen from the front, it meets the eyeball."""
    eye = face.parts[f"{side}_eye"]
    is_eye = np.zeros(len(pose.vertices), bool)
    is_eye[eye] = True
    view = frontal_camera(pose, 900, frame=pose.vertices[eye])
    picture = RayCaster(pose).depth_image(*view)
    inside = (picture.faces >= 0) & is_eye[pose.faces[picture.faces, 0]]
    near = np.zeros_like(inside)
    near[1:-1, 1:-1] = inside[:-2, 1:-1] | inside[2:, 1:-1] | inside[1:-1, :-2] | inside[1:-1, 2:]
    rim = near & ~inside & (picture.faces >= 0)
    return Attachment(picture.faces[rim], picture.barycentric[rim]).points(pose)


def on_margin(points: np.ndarray, group: str, rim: np.ndarray) -> np.ndarray:
    """Lay an eye's landmarks on the lids' margin: corners on its ends, the others at the same share of the way."""
    outer, inner = EYES[group.removeprefix("eye_")]
    side = np.sign(points[outer, 0])
    ends = rim[np.argmax(side * rim[:, 0])], rim[np.argmin(side * rim[:, 0])]
    chord = ends[1][:2] - ends[0][:2]
    across = np.array([-chord[1], chord[0]]) * np.sign(-chord[0])
    above = (rim[:, :2] - ends[0][:2]) @ across < 0
    share_rim = (rim[:, :2] - ends[0][:2]) @ chord / (chord @ chord)
    members = list(GROUPS[group])
    lower = members[1 : members.index(inner)]
    span = points[inner, :2] - points[outer, :2]
    moved = points.copy()
    for i in members:
        share = (points[i, :2] - points[outer, :2]) @ span / (span @ span)
        lid = np.flatnonzero(~above if i in lower else above)
        moved[i] = rim[lid[np.argmin(np.abs(share_rim[lid] - share))]]
    moved[outer], moved[inner] = ends
    return moved


def on_rims(face: BundledFace, pose: Mesh, points: np.ndarray) -> np.ndarray:
    """Lay the inner lips' landmarks on the rims of the lips: down each column from the outer contour to the gap."""
    ajar = face.rig.mesh(weights(face, {"jawOpen": AJAR}))
    near = np.linalg.norm(ajar.vertices - points[list(GROUPS["lips_inner"])].mean(axis=0), axis=1) < 40
    view = frontal_camera(ajar, 900, frame=ajar.vertices[near])
    picture = RayCaster(ajar).depth_image(*view)
    is_skin = np.zeros(len(ajar.vertices), bool)
    is_skin[face.parts["skin"]] = True
    skin = (picture.faces >= 0) & is_skin[ajar.faces[picture.faces, 0]]
    fixed = fix(face, pose, points)
    pixels = view.camera.project(view.T_camera_face.apply(fixed.points(ajar))).round().astype(int)
    moved = points.copy()
    for i, j in zip(GROUPS["lips_inner"], GROUPS["lips_outer"], strict=True):
        if i in CORNERS:
            continue
        column, step = pixels[i, 0], 1 if points[j, 1] > points[i, 1] else -1
        row = pixels[j, 1]
        while skin[row + step, column] and abs(np.diff(picture.depth[[row, row + step], column])[0]) < LEDGE_MM:
            row += step
        rim = Attachment(picture.faces[row, [column]], picture.barycentric[row, [column]])
        moved[i] = rim.points(pose)[0]
    return moved


def on_midline(face: BundledFace, pose: Mesh, points: np.ndarray) -> np.ndarray:
    """The nearest points on the skin's edges in the mirror plane."""
    own = face.mirror == np.arange(len(face.mirror))
    skin = pose.faces[np.isin(pose.faces, face.parts["skin"]).all(axis=1)]
    edges = skin[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    ends = pose.vertices[edges[own[edges].all(axis=1)]]
    share = np.linspace(0, 1, 51)[:, None, None]
    samples = (ends[:, 0] * (1 - share) + ends[:, 1] * share).reshape(-1, 3)
    return samples[np.linalg.norm(points[:, None] - samples, axis=2).argmin(axis=1)]


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


if __name__ == "__main__":
    main()
