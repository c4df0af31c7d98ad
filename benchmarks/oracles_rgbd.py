"""What an RGB-D take of a stranger allows at best: asked by `oracles.py --only rgbd`."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.optimize import lsq_linear
from shares import shares

from mien.depth import RGBDFrame
from mien.faces.bundled import load_face
from mien.landmarks.detector import FaceLandmarker, Landmarks2D
from mien.landmarks.on_rig import LandmarkMap
from mien.mesh import ClosestPoint, Mesh, vertex_normals
from mien.register.rigid import procrustes
from mien.rgbd import read_rgbd
from mien.rgbd.take import RgbdTake
from mien.rig import Rig
from mien.rig.transfer import transfer_rig
from mien.tracking import tracker
from mien.tracking.model import TrackingModel, tracking_model
from mien.tracking.person.personalize import Personal, personalize
from mien.tracking.rigid import RigidResult
from mien.tracking.tracker_context import TrackConfig, TrackResult, initial_state, tracker_context
from mien.transforms import Transform

THIN = 5
"""Every so manieth point of the skin tells weights and scales: there are thousands."""
EACH = 3
"""Every so manieth frame has its best weights found."""
LEAST_SCALE, LARGEST_SCALE, SCALE_PRIOR = 0.2, 3.0, 1e-2
"""Bounds of a shape's scale; what its distance from 1 counts, of the mean of what the skin says."""
RELEARN = 0.3
"""Ridge of shapes that are relearnt, in summed squared weights."""
ACTIVE = 0.01
"""A shape whose weight varies by less over the take is not relearnt."""
FAR_MM, LARGEST_MM = 3.0, 2.0
"""Skin farther from the true neutral than the first has no place there; none is moved by more than the second."""


@dataclass(frozen=True)
class Oracle:
    """A take, its truth, the person's rig."""

    take: RgbdTake
    truth: dict[str, np.ndarray]
    personal: Personal
    seen: list[tuple[RGBDFrame, Landmarks2D | None]]

    @cached_property
    def T_camera_head(self) -> Transform:
        """The true head, a pose a frame."""
        return Transform(self.truth["rotation"].astype(float), self.truth["translation"].astype(float))

    @cached_property
    def skin(self) -> np.ndarray:
        """Vertices that are judged."""
        return np.flatnonzero(self.truth["open"])

    @cached_property
    def true(self) -> np.ndarray:
        """Their motion from the neutral, (t, v, 3) mm, head space."""
        return np.tensordot(self.truth["coefficients"], self.truth["modes"][:, self.skin], 1)

    @cached_property
    def calm(self) -> int:
        """A frame in which the true face is in its neutral."""
        return int(np.flatnonzero(self.truth["still"])[0])

    def track(self, model: TrackingModel, config: TrackConfig = TrackConfig(), before: Callable | None = None):
        """The take's results; `before` is told the number of each frame."""
        context = tracker_context(model, self.take.camera, config)
        state, out = initial_state(context), []
        for number, (frame, marks) in enumerate(self.seen):
            if before is not None:
                before(number)
            state, result = tracker.step(context, frame, marks, state)
            out.append(result)
        return out

    def places(self, model: TrackingModel, results: list[TrackResult]) -> tuple[np.ndarray, np.ndarray]:
        """Triangle and barycentric coordinates of each point of skin on the rig, told in the calm frame."""
        first = results[self.calm]
        placed = first.T_camera_face.apply(model.whole(first.weights, first.vertices))
        neutral = self.truth["neutral"][self.skin] + self.true[self.calm]
        found = ClosestPoint(Mesh(placed, model.rig.neutral.faces)).query(self.T_camera_head[self.calm].apply(neutral))
        return found.faces, found.barycentric

    def motion(self, model: TrackingModel, results: list[TrackResult]) -> np.ndarray:
        """The tracked skin's motion from the rig's neutral, as the true head sees it, (t, v, 3) mm."""
        faces, barycentric = self.places(model, results)
        corners = model.rig.neutral.faces[faces]
        out = []
        for frame, result in enumerate(results):
            moved = model.whole(result.weights, result.vertices) - model.rig.neutral.vertices
            own = np.einsum("pc,pcd->pd", barycentric, moved[corners])
            out.append((self.T_camera_head[frame].inverse() @ result.T_camera_face).rotate(own))
        return np.stack(out)

    def say(self, what: str, found: np.ndarray, every: int = 1) -> None:
        """One line."""
        print(f"rgbd, {what}: {shares(found, self.true[::every])}", flush=True)


def rgbd(folder: Path) -> None:
    """Every oracle of one take."""
    take = read_rgbd(folder / "take")
    personal = personalize(take)
    with FaceLandmarker("video") as eyes:
        seen = [(frame, None if frame.color is None else eyes.detect(frame.color, frame.time)) for frame in take]
    oracle = Oracle(take, dict(np.load(folder / "truth.npz")), personal, seen)
    model = tracking_model(personal.rig, personal.landmarks)
    results = oracle.track(model)
    found = oracle.motion(model, results)
    oracle.say("tracked", found)
    oracle.say("without its error along the skin", across_only(oracle, found))
    scaled = of_shapes(oracle, model, results, found)
    again(oracle, scaled, personal.landmarks, "tracked anew with those scales")
    T_head_face = head_from_face(oracle, model, results)
    there = transfer_rig(load_face().rig, true_neutral(oracle, model, T_head_face))
    again(oracle, there, personal.landmarks, "tracked with the true neutral")
    oracle.say("tracked in the true pose", oracle.motion(model, in_true_pose(oracle, model, T_head_face)))


def again(oracle: Oracle, rig: Rig, landmarks: LandmarkMap, what: str) -> None:
    """Track the take with another rig."""
    model = tracking_model(rig, landmarks)
    oracle.say(what, oracle.motion(model, oracle.track(model)))


def across_only(oracle: Oracle, found: np.ndarray) -> np.ndarray:
    """The motion with the error's part along the skin taken away."""
    neutral = Mesh(oracle.truth["neutral"].astype(float), oracle.truth["faces"])
    normals = vertex_normals(neutral.vertices, neutral.faces)[oracle.skin]
    off = found - oracle.true
    across = np.einsum("tvd,vd->tv", off, normals)[..., None] * normals
    print(f"rgbd, error across the skin {size(across):.2f} mm, along it {size(off - across):.2f} mm")
    return oracle.true + across


def size(vectors: np.ndarray) -> float:
    """Mean length."""
    return float(np.linalg.norm(vectors, axis=-1).mean())


def of_shapes(oracle: Oracle, model: TrackingModel, results: list[TrackResult], found: np.ndarray) -> Rig:
    """What the rig's shapes can say, by weights and scales given the truth; the rig with the best scales."""
    faces, barycentric = oracle.places(model, results)
    rig = model.rig
    turn = oracle.T_camera_head[oracle.calm].inverse() @ results[oracle.calm].T_camera_face
    shapes = turn.rotate(np.einsum("pc,kpcd->kpd", barycentric, rig.deltas[:, rig.neutral.faces[faces]]))
    names = [str(name) for name in oracle.truth["arkit_names"]]
    played = oracle.truth["arkit"][:, [names.index(name) for name in rig.names]]
    ours = np.stack([result.weights for result in results])
    oracle.say("weights as played", np.tensordot(played, shapes, 1))
    for what, low, high in (("best weights in 0..1", 0.0, 1.0), ("best weights of either sign", -5.0, 5.0)):
        oracle.say(what, np.tensordot(best_weights(shapes, oracle.true[::EACH], low, high), shapes, 1), EACH)
    scales = best_scales(shapes, ours, oracle.true)
    oracle.say("our weights, best scale a shape", np.tensordot(ours * scales, shapes, 1))
    oracle.say("our weights, shapes relearnt, tenths of the take left out by turns", relearnt(ours, found, oracle.true))
    return replace(rig, deltas=rig.deltas * scales[:, None, None])


def best_weights(shapes: np.ndarray, true: np.ndarray, low: float, high: float) -> np.ndarray:
    """Least-squares weights within bounds, one row a frame."""
    A = shapes[:, ::THIN].reshape(len(shapes), -1).T
    gram = A.T @ A
    L = np.linalg.cholesky(gram + 1e-3 * np.trace(gram) / len(gram) * np.eye(len(gram)))
    says = [np.linalg.solve(L, A.T @ frame[::THIN].ravel()) for frame in true]
    return np.stack([lsq_linear(L.T, y, (low - 1e-9, high)).x for y in says])


def best_scales(shapes: np.ndarray, weights: np.ndarray, true: np.ndarray) -> np.ndarray:
    """One scale a shape, held near 1, that brings the weighted shapes nearest to the truth."""
    A = shapes[:, ::THIN].reshape(len(shapes), -1).T
    gram = (A.T @ A) * (weights.T @ weights)
    product = np.einsum("tk,tk->k", weights, true[:, ::THIN].reshape(len(true), -1) @ A)
    prior = SCALE_PRIOR * np.trace(gram) / len(gram)
    L = np.linalg.cholesky(gram + prior * np.eye(len(gram)))
    return lsq_linear(L.T, np.linalg.solve(L, product + prior), (LEAST_SCALE, LARGEST_SCALE)).x


def relearnt(weights: np.ndarray, found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Shapes corrected by the truth of nine tenths of the take (ridge), under the weights of the other."""
    W = weights[:, weights.std(axis=0) > ACTIVE]
    missing, out = (true - found).reshape(len(true), -1), found.copy()
    for left_out in np.array_split(np.arange(len(true)), 10):
        kept = np.setdiff1d(np.arange(len(true)), left_out)
        gram = W[kept].T @ W[kept] + RELEARN * np.eye(W.shape[1])
        corrections = np.linalg.solve(gram, W[kept].T @ missing[kept])
        out[left_out] += (W[left_out] @ corrections).reshape(-1, *true.shape[1:])
    return out


def head_from_face(oracle: Oracle, model: TrackingModel, results: list[TrackResult]) -> Transform:
    """The rig's space onto the truth's: its neutral laid on the true one, from where it was in a calm frame."""
    T_head_face = oracle.T_camera_head[oracle.calm].inverse() @ results[oracle.calm].T_camera_face
    surface = ClosestPoint(Mesh(oracle.truth["neutral"].astype(float), oracle.truth["faces"]))
    front = model.rig.neutral.vertices[model.front]
    for _ in range(15):
        found = surface.query(T_head_face.apply(front))
        near = found.distances < np.percentile(found.distances, 80)
        T_head_face = procrustes(front[near], found.points[near], np.ones(near.sum())).transform
    return T_head_face


def true_neutral(oracle: Oracle, model: TrackingModel, T_head_face: Transform) -> Mesh:
    """The rig's neutral, its front moved onto the true one along its normals."""
    neutral = model.rig.neutral
    surface = ClosestPoint(Mesh(oracle.truth["neutral"].astype(float), oracle.truth["faces"]))
    front = neutral.vertices[model.front]
    found = surface.query(T_head_face.apply(front))
    normals = vertex_normals(neutral.vertices, neutral.faces)[model.front]
    off = np.einsum("vd,vd->v", T_head_face.inverse().apply(found.points) - front, normals)
    height = np.clip(off * (found.distances < FAR_MM) * model.fade, -LARGEST_MM, LARGEST_MM)
    vertices = neutral.vertices.copy()
    vertices[model.front] += height[:, None] * normals
    return neutral.with_vertices(vertices)


def in_true_pose(oracle: Oracle, model: TrackingModel, T_head_face: Transform) -> list[TrackResult]:
    """The take tracked with the head where it truly is, and kept there."""
    poses = oracle.T_camera_head @ T_head_face
    config = TrackConfig()
    config = replace(config, fit=replace(config.fit, pose=False, refine_pose_mm=0.0), damp_pose_mm=0.0)
    now = [0]

    def told(context, observation, state, T_camera_face) -> RigidResult:
        return RigidResult(poses[now[0]], 0.5, 1.0, True, 1)

    with patch.object(tracker, "rigid_motion", told):
        return oracle.track(model, config, before=lambda number: now.__setitem__(0, number))
