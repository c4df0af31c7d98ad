"""What a take on scans of a stranger allows at best: asked by `oracles.py --only scans`."""

import json
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from shares import shares, world_share

from mien.clip import Markers
from mien.faces import load_face
from mien.io.markers import read_markers
from mien.mesh import Attachment, ClosestPoint, Mesh
from mien.scans.correspond.still_skin import moved_shapes
from mien.scans.marker_consensus import consensus_attachment, consensus_standoff
from mien.scans.pipeline import RegisteredScans, ScansConfig, register_scans
from mien.scans.placed_scans import PlacedScan
from mien.scans.reconstruct import meet_markers, solve_on_scans
from mien.scans.scan_files import match_scans, read_scans
from mien.scans.scan_rig import ScanRig, rig_of_scans
from mien.takes.gaps import fill_gaps
from mien.transforms import Transform

DENSITY = 1
"""A coarse template, for minutes less."""
NEAR_MM = 3.0
"""Skin farther from the true scan has no place there."""
STEP = 6
"""Every so many frames are scored."""


@dataclass(frozen=True)
class Oracle:
    """A take of markers, its scans as registered, and the truth of both."""

    markers: Markers
    truth: dict[str, np.ndarray]
    true_scans: dict[str, dict[str, np.ndarray]]
    found: RegisteredScans

    @cached_property
    def T_lab_head(self) -> Transform:
        """The true head, a pose a frame."""
        return Transform(self.truth["rotation"].astype(float), self.truth["translation"].astype(float))

    @cached_property
    def skin(self) -> np.ndarray:
        """Vertices that are judged."""
        return np.flatnonzero(self.truth["open"])

    @cached_property
    def frames(self) -> np.ndarray:
        """Frames that are judged."""
        return np.arange(0, len(self.truth["times"]), STEP)

    @cached_property
    def true(self) -> np.ndarray:
        """The skin's motion from the neutral, (t, v, 3) mm, head space."""
        return np.tensordot(self.truth["coefficients"][self.frames], self.truth["modes"][:, self.skin], 1)

    @cached_property
    def calm(self) -> int:
        """A frame in which the true face is in its neutral."""
        return int(np.flatnonzero(self.truth["still"])[0])

    @cached_property
    def before_scanner(self) -> np.ndarray:
        """The true vertices of the take before the scanner, in the space in which the scans lie, (scans, n, 3) mm."""
        mean = self.face(self.truth["coefficients"].mean(axis=0))
        rows = KDTree(self.truth["frozen"]).query(mean)[1]
        shown = [self.true_scans[scan.name]["vertices"][rows].astype(float) for scan in self.found.scans]
        return np.stack([scan.T_face_scan.apply(x) for scan, x in zip(self.found.scans, shown, strict=True)])

    @cached_property
    def in_frames(self) -> np.ndarray:
        """The same as they are in the scans' frames, where each scan's head is."""
        out = []
        for scan in self.found.scans:
            face = self.face(self.truth["coefficients"][scan.frame])
            out.append(self.T_face_head(scan).apply(face))
        return np.stack(out)

    def T_face_head(self, scan: PlacedScan) -> Transform:
        """The true head where a scan was placed."""
        pose = self.true_scans[scan.name]
        T_scan_head = Transform(pose["rotation"].astype(float), pose["translation"].astype(float))
        return scan.T_face_scan @ T_scan_head

    def in_true_heads(self) -> "Oracle":
        """The same with every scan in the head of the resting one, and the markers of its frame where they were."""
        found, T_face_head = self.found, self.T_face_head(self.found.scans[0])
        moves = [_rigid(T_face_head @ self.T_face_head(scan).inverse()) for scan in found.scans]
        taken = fill_gaps(self.T_lab_head.inverse().apply(self.markers.positions), self.markers.rate)
        there = T_face_head.apply(taken[[scan.frame for scan in found.scans]])
        goals = np.where(np.isfinite(there), there, moved_shapes(moves, found.scan_rig.expressions))
        fine = replace(found.fine, vertices=moved_shapes(moves, found.fine.vertices))
        scans = tuple(scan.moved(T) for scan, T in zip(found.scans, moves, strict=True))
        rig = replace(found.scan_rig, expressions=goals)
        return replace(self, found=replace(found, scans=scans, fine=fine, scan_rig=rig))

    def face(self, coefficients: np.ndarray) -> np.ndarray:
        """True vertices, head space, mm."""
        return self.truth["neutral"].astype(float) + np.tensordot(coefficients, self.truth["modes"], 1)

    def placed(self, places: np.ndarray) -> np.ndarray:
        """The skin of all scans where the true vertices put what each vertex covers on the resting scan.

        Args:
            places: the true vertices, (scans, n, 3) mm.
        """
        faces, shapes = self.truth["faces"].astype(int), self.found.fine.vertices
        under = ClosestPoint(Mesh(self.before_scanner[0], faces)).query(shapes[0])
        known = (under.distances < NEAR_MM) & self.found.template.shown
        attachment = under.attachment()
        out = shapes.copy()
        for shape, vertices in zip(out, places, strict=True):
            shape[known] = attachment.points(Mesh(vertices, faces))[known]
        return out

    def rig(self, shapes: np.ndarray) -> ScanRig:
        """The rig of scans whose skin is at `shapes`; it meets the markers and leans on none."""
        found, template, scans = self.found, self.found.template, self.found.scans
        points = [on.attachment.points(scan.mesh) for on, scan in zip(found.on_scans.scans, scans, strict=True)]
        covered, goals = found.covered, found.scan_rig.expressions
        attachment = consensus_attachment(template, shapes, points, covered)
        standoff = consensus_standoff(template, shapes, attachment, goals, covered, found.on_scans.standoff)
        skin = meet_markers(template.skin, shapes, attachment, goals, standoff, covered)
        return replace(
            found.scan_rig,
            rig=rig_of_scans(template, skin, [scan.name for scan in scans]),
            attachment=Attachment(template.skin_faces[attachment.faces], attachment.barycentric),
            standoff=standoff,
        )

    def say(self, what: str, scan_rig: ScanRig) -> None:
        """Play the take on a rig; one line."""
        solved = solve_on_scans(self.markers, scan_rig)
        rig, weights = solved.performance.rig, solved.performance.weights
        T_head_face = self.T_lab_head.inverse() @ solved.T_lab_face
        rest = T_head_face[self.calm].apply(rig.vertices(weights[self.calm]))
        under = ClosestPoint(Mesh(rest, rig.neutral.faces)).query(self.truth["neutral"][self.skin].astype(float))
        corners = rig.neutral.faces[under.faces]
        neutral = np.einsum("pc,pcd->pd", under.barycentric, rig.neutral.vertices[corners])
        shapes = np.einsum("pc,kpcd->kpd", under.barycentric, rig.deltas[:, corners])
        own = np.tensordot(weights[self.frames], shapes, 1)
        T = T_head_face[self.frames]
        world = world_share(T.apply(neutral + own), self.true)
        print(f"scans, {what}: {shares(T.rotate(own), self.true)}, {world}", flush=True)


def _rigid(T: Transform) -> Transform:
    return Transform(T.rotation, T.translation)


def scans(takes: Path) -> None:
    """Every oracle of one take on its scans."""
    folder = takes / "markers100"
    chosen = tuple(json.loads((folder / "selection.json").read_text())["frames"])
    files, given, _ = read_scans(match_scans(takes / "scans", chosen)[0], None)
    markers = read_markers(folder / "take.c3d")
    found = register_scans(markers, given, [file.frame for file in files], load_face(), ScansConfig(density=DENSITY))
    true_scans = {file.name: dict(np.load(takes / "truth_scans" / f"{file.name}.npz")) for file in files}
    oracle = Oracle(markers, dict(np.load(folder / "truth.npz")), true_scans, found)
    there = oracle.in_true_heads()
    oracle.say("as registered", found.scan_rig)
    oracle.say("in the true heads, without the lean", there.rig(there.found.fine.vertices))
    oracle.say("true places of the scans' vertices", oracle.rig(oracle.placed(oracle.before_scanner)))
    oracle.say("both", there.rig(there.placed(there.before_scanner)))
    oracle.say("both, of scans that show their frames exactly", there.rig(there.placed(there.in_frames)))
