"""`mien demo blendshapes`: expressions held before a staged sensor become a textured rig, which two people play."""

from dataclasses import replace
from pathlib import Path

import numpy as np

FRAMES, CLIP_FRAMES, RATE = 10, 40, 15.0
"""Of a held expression; of a clip; of a clip, a second."""
FILM_PIXELS = 360
"""Side of the clips' films."""
CALM = 16
"""Frames at a clip's beginning in which its driver holds still and calm, as `mien personalize` asks for."""
COMBINED: dict[str, dict[str, float]] = {
    "smile": {"smile": 1.0},
    "blink in a smile": {"smile": 1.0, "eyes_closed": 1.0},
    "kiss": {"mouthPucker": 1.0},
    "brows in a kiss": {"mouthPucker": 1.0, "brows_up": 1.0},
    "aa": {"jawOpen": 0.8},
    "oh": {"jawOpen": 0.5, "mouthPucker": 0.5},
    "ee": {"smile": 0.6, "jawOpen": 0.2},
    "frown, jaw open": {"frown": 1.0, "jawOpen": 0.7},
}
"""Figure 5: expressions of several regions at once, and mouths of speech."""
PLAYED = ("smile", "brows_up", "jawOpen", "mouthPucker")
"""What the clips go through."""
WORN = (("smile", "brows_up"), ("jawOpen", "eyes_closed"), ("mouthPucker", "frown"), ("mouthLeft", "brows_up"))
"""What is played under a headset: a mouth, and what is hidden."""
WORN_S, WORN_SHARE = 0.5, 0.8
"""How long an expression takes then, and before; what the head takes of the sensor's pictures."""


def demo_blendshapes(folder: Path, seed: int) -> None:
    """Leaves captures/, scans/, me.glb, both clips (.glb, .mp4), index.html, figures and report.html in `folder`."""
    from ..blendshapes.build.rig_files import write_textured_rig
    from ..blendshapes.expression import RigConfig
    from ..blendshapes.pipeline import build_rig
    from ..experiments.blendshapes_stage import EXPRESSIONS, CaptureStageConfig, capture_actor
    from ..faces import load_face
    from ..io.gltf import write_performance
    from .bar import bar

    config = CaptureStageConfig(frames=FRAMES)
    face = load_face()
    with bar() as progress:
        actor = capture_actor(seed, config)
        captures = []
        for done, name in enumerate(EXPRESSIONS):
            progress.update("scanning", done, len(EXPRESSIONS))
            captures.append(scanned(actor, name, seed, config, folder))
        built = build_rig(captures, "neutral", face, True, RigConfig(), progress)
        write_textured_rig(folder / "me.glb", built.textured)
        stranger = capture_actor(seed + 1, replace(config, levels=0))
        clips = {
            "own": driven(actor, built, seed, False, progress),
            "foreign": driven(stranger, built, seed + 1, True, progress),
        }
        for name, clip in clips.items():
            write_performance(folder / f"{name}.glb", clip.performance)
        playing(folder, clips, built.textured, progress)
        worn = under_headset(built, seed, config, progress)
        write_performance(folder / "headset.glb", worn.driven)
        errors = true_errors(built, actor, face)
        figures = draw_figures(built, clips, face, worn)
        report(folder, errors, figures, clips, built, worn)
    for line in built.left_out:
        print(line)
    for name, row in errors.items():
        print(f"{name:12} {row['mean']:.2f} mm, drift {row['drift median']:.1f} texels")
    print(f"{folder}/: captures/  scans/  me.glb  own.glb  own.mp4  foreign.glb  foreign.mp4")
    print(f"{folder}/: headset.glb  figure_*.png")
    print(f"{folder}/index.html plays both; {folder}/report.html tells how near they are")
    print(f"next: mien view {folder}/own.glb --textured {folder}/me.glb")


def scanned(actor, name: str, seed: int, config, folder: Path):
    """One expression's film fused, kept as map and as mesh with texture."""
    from ..blendshapes.captures import Capture
    from ..blendshapes.cylinder_map import mesh_of_map
    from ..blendshapes.map_file import write_map
    from ..blendshapes.scan.pipeline import scan_take
    from ..experiments.blendshapes_stage import staged_capture
    from ..io.meshes import write_mesh

    for part in ("captures", "scans"):
        (folder / part).mkdir(exist_ok=True)
    take = staged_capture(actor, name, seed, config).take
    frames = list(take)
    found = scan_take(replace(take, name=name, frames=lambda: iter(frames)))
    write_map(folder / "captures" / f"{name}.exr", found.map)
    made = mesh_of_map(found.map, 2)
    write_mesh(folder / "scans" / f"{name}.ply", made.mesh, made.texture)
    return Capture(found.map, f"{found.used} frames fused")


def driven(actor, built, seed: int, foreign: bool, progress):
    """A film of someone, and the rig played by it."""
    from ..experiments.blendshapes_figures import Driven
    from ..experiments.blendshapes_stage import capture_weights
    from ..rig.retarget import retarget
    from ..stage import FilmConfig, HeadMotion, film
    from ..tracking.person.personalize import personalize
    from ..tracking.pipeline import track_take

    head = HeadMotion(rotation=0.04, translation=5.0)
    keys = np.array([capture_weights(name) for name in ("neutral", *PLAYED, "neutral")])
    moving = np.linspace(0, len(keys) - 1, CLIP_FRAMES - CALM)
    at = np.concatenate([np.zeros(CALM), moving])
    low = np.minimum(at.astype(int), len(keys) - 2)
    share = np.clip(2 * (at - low) - 0.5, 0, 1)[:, None]
    weights = (1 - share) * keys[low] + share * keys[low + 1]
    take = film(actor, weights, RATE, FilmConfig(head=head), seed).take
    frames = list(take)
    pictures = [frame.color for frame in frames if frame.color is not None]
    kept = replace(take, frames=lambda: iter(frames))
    rig = arkit_part(built.textured.rig)
    if not foreign:
        return Driven(pictures, track_take(kept, rig, progress=progress).performance)
    person = personalize(kept, progress=progress)
    tracked = track_take(kept, person.rig, person.landmarks, progress=progress)
    return Driven(pictures, retarget(tracked.performance, rig, correctives=False).performance)


def under_headset(built, seed: int, config, progress):
    """The rig played by its own person, whose upper face is hidden; without wrinkles, which the small sensor misses."""
    from ..experiments.blendshapes_stage import EXPRESSIONS, capture_actor
    from ..experiments.hidden_face import HiddenFaceConfig, hidden_face

    person = capture_actor(seed, replace(config, levels=0))
    poses = tuple({**EXPRESSIONS[seen], **EXPRESSIONS[hidden]} for seen, hidden in WORN)
    session = HiddenFaceConfig(each_s=WORN_S, times=1, poses=poses)
    return hidden_face(person, seed, session, progress, arkit_part(built.textured.rig))


def playing(folder: Path, clips, textured, progress) -> None:
    """Both clips as films, and side by side in `index.html`, textures in step."""
    from ..blendshapes.play import textures_of
    from ..pictures import write_mp4
    from ..pictures.show import Shot, performance_frames
    from ..viewer.page_files import export_page
    from ..viewer.studio_scene import Shown, pack_scene

    shown = []
    for name, clip in clips.items():
        played = clip.performance
        textures = textures_of(played, folder / "me.glb")
        shot = Shot(size=FILM_PIXELS)
        images = performance_frames(played, range(len(played)), shot, progress=progress, textures=textures)
        write_mp4(folder / f"{name}.mp4", images, played.rate)
        shown.append(Shown(f"{name}.glb", played, textured=textured))
    export_page(folder / "index.html", pack_scene(shown))


def arkit_part(rig):
    """The rig with its ARKit shapes alone: captures of other names are mixes of them."""
    from ..faces.arkit import ARKIT_NAMES

    rows = [rig.index(name) for name in ARKIT_NAMES]
    return replace(rig, deltas=rig.deltas[rows], names=ARKIT_NAMES)


def true_errors(built, actor, face) -> dict[str, dict[str, float]]:
    """Each expression's errors by true correspondence."""
    from ..experiments.blendshapes_score import true_skin
    from ..experiments.blendshapes_stage import capture_weights
    from ..experiments.blendshapes_ways import errors_of

    truth = true_skin(actor, built.neutral.map, built.neutral.artist)
    mesh = built.neutral.artist.mesh
    rows = {}
    for shape in built.shapes:
        found = np.where(shape.seen[:, None], mesh.vertices + shape.delta, np.nan)
        rows[shape.name] = errors_of(found, truth, capture_weights(shape.name), built.neutral, face)
    return rows


def draw_figures(built, clips, face, worn) -> dict[str, np.ndarray]:
    """Figures 1 and 3 to 10, by number."""
    from ..blendshapes.align import AlignedCapture
    from ..blendshapes.correspond.landmarks import landmarks_on_map
    from ..experiments import blendshapes_figures as draw
    from ..experiments.blendshapes_ways import template_fit
    from ..experiments.hidden_face import moments
    from ..transforms import Transform

    shapes = {shape.name: shape for shape in built.shapes}
    aside = shapes["mouthLeft"]
    marks = landmarks_on_map(aside.map)
    aligned = AlignedCapture(aside.map, marks, Transform.identity(), aside.rms_mm)
    maps = {"neutral": (built.neutral.map, built.neutral.landmarks), "mouthLeft": (aside.map, marks)}
    names = [shape.name for shape in built.shapes]
    peaks = np.linspace(CALM, CLIP_FRAMES - 1, len(PLAYED) + 2)[1:-1]
    held = [int(i) for i in peaks.round()]
    textured = built.textured
    seen = [frame.color for frame in worn.frames]
    headset = draw.Driven(seen, worn.driven, WORN_SHARE)
    return {
        "1": draw.drift_sheet(built.neutral, aside, aligned, template_fit(aligned, face)),
        "3": draw.landmark_sheet(maps),
        "4": draw.warp_sheet(built.neutral, [shapes["smile"], shapes["jawOpen"]]),
        "5": draw.posed_sheet(textured, COMBINED, 4),
        "6": draw.tracking_sheet(textured.rig, names),
        "7": draw.puppet_sheet(clips["own"], textured, held),
        "8": draw.puppet_sheet(clips["foreign"], textured, held),
        "9": draw.shape_sheet(textured.rig, names),
        "10": draw.puppet_sheet(headset, textured, moments(worn, len(WORN))),
    }


def report(folder: Path, errors, figures, clips, built, worn) -> None:
    """Figures as files, and `report.html`, which begins with the face that moves."""
    from ..experiments.hidden_face import hidden_errors, lower_skin
    from ..pictures import write_png
    from ..reports.page import Report
    from ..viewer.moving_page import moving_page

    lead = "A person's rig from eight expressions held before one sensor (Casas et al. 2016)."
    page = Report("Textured blendshapes", lead)
    mean = np.mean([row["mean"] for row in errors.values()])
    page.verdict(f"Skin is found to {mean:.2f} mm, mean over {len(errors)} expressions, by true correspondence.")
    page.page(moving_page(clips["own"].performance, "own.glb", textured=built.textured))
    rows = [[name, *row.values()] for name, row in errors.items()]
    units = ("mean, mm", "median, mm", "p95, mm", "drift median", "drift p95", "beyond 60 degrees, mm")
    page.heading("How near to the skin").table(rows, ("expression", *units), "Drift in texels of 1024 a side.")
    for number, (title, caption) in CAPTIONS.items():
        write_png(folder / f"figure_{number}.png", figures[number])
        page.heading(f"Figure {number}: {title}").figure(figures[number], caption)
    rows = [[part, *row.values()] for part, row in hidden_errors(worn).items()]
    moved, frozen = lower_skin(worn)
    told = f"Skin of the lower face moves to {moved:.2f} mm from the true one; of a frozen face {frozen:.2f} mm."
    page.heading("Weights under the headset").table(rows, ("shapes", "rms error", "of zeros", "of a mean face"), told)
    for line in built.left_out:
        page.text(line)
    page.write(folder / "report.html")


CAPTIONS = {
    "1": ("texture drift", "Brows of `mouthLeft`, which do not move: by our warp, and by a template laid on it."),
    "3": ("landmarks", "On the neutral's map and an expression's."),
    "4": ("warping", "The neutral, an expression, and the expression brought to the neutral's places."),
    "5": ("combinations", "Masks keep each expression to its region; textures blend in step."),
    "6": ("surface tracking", "A checked texture on every shape."),
    "7": ("puppeteering", "The captured person drives their own rig."),
    "8": ("another driver", "Someone else drives it."),
    "9": ("shapes", "Without texture."),
    "10": ("a headset", "The lower face is tracked by depth; strain gauges in the lining tell brows and lids."),
}
