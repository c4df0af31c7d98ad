"""`mien demo rgbd`: a staged RGB-D film becomes a rig and a performance, is taken apart stage by stage, and scored."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.ndimage import minimum_filter

RATE = 30.0
APART_S = 0.05
"""Between the shades of two expressions on a chart there is twice this, seconds."""


def demo_rgbd(folder: Path, seed: int, seconds: float, figures: bool) -> None:
    """Leaves take/, rig.glb, perf.glb, preview.png and report.html in `folder`."""
    from ..experiments.tracking_ablation import Remembered, compare, left_out
    from ..io.gltf import write_performance, write_rig
    from ..pictures import write_png
    from ..reports.tracking import preview, take_report, weights_section
    from ..reports.verdict import truth_verdict
    from ..rgbd import read_rgbd, write_rgbd
    from ..stage import score_performance
    from ..tracking.model import tracking_model
    from ..tracking.person.personalize import personalize
    from ..tracking.pipeline import track_take
    from ..viewer.moving_page import moving_page
    from .bar import bar
    from .personalize import beside
    from .track import summary

    eyes = Remembered()
    with bar() as progress:
        script, staged = stage(seed, seconds)
        write_rgbd(folder / "take", staged.take, color="jpg", progress=progress)
        take = read_rgbd(folder / "take")
        person = personalize(take, progress=progress)
        write_rig(folder / "rig.glb", person.rig)
        person.landmarks.save(beside(folder / "rig.glb"))
        tracked = track_take(take, person.rig, person.landmarks, eyes, progress=progress)
        write_performance(folder / "perf.glb", tracked.performance)
        picture = preview(take, tracked, shown(script), progress=progress)
        write_png(folder / "preview.png", picture)
        score = score_performance(tracked.performance, staged.truth)
        verdict = truth_verdict(score.ratio, score.ratio_strongest)
        report = take_report(replace(take, name="A staged film"), tracked, picture, spans=spans(script))
        report.verdict(verdict).page(moving_page(tracked.performance, "perf.glb"))
        add_truth(report, score, staged.truth, tracked, eyes)
        if figures:
            model = tracking_model(person.rig, person.landmarks)
            study = compare(take, model, eyes, left_out(), progress=progress)
            add_stages(report, study, staged.truth)
            add_learning(report, study, tracked, script)
        weights_section(report, tracked.performance)
        report.write(folder / "report.html")
    print(summary(folder / "perf.glb", tracked, take))
    print(verdict)
    print(f"{folder}/: take/  rig.glb  perf.glb  preview.png  report.html (open it: the face moves there)")
    print(f"next: mien view {folder}/perf.glb; mien demo rgbd --figures takes the tracker apart, stage by stage")


def stage(seed: int, seconds: float):
    """The script and the film: calm, five expressions in two rounds, a hand before the face between the rounds."""
    from ..stage import FilmConfig, film, make_performer
    from ..stage.script.repeated_script import repeated_script

    script = repeated_script(RATE, seconds, seed)
    between = next(start for name, start, _ in script.cues if name.endswith("again")) / RATE
    config = FilmConfig(occlusions=((between - 0.05, 0.1),))
    return script, film(make_performer(seed), script.weights, RATE, config, seed)


def spans(script) -> list[tuple[float, float, str]]:
    """The expressions as a chart shades them, a little apart."""
    _, *expressions = script.cues
    found = []
    for name, start, end in expressions:
        first = start / script.rate + APART_S
        last = end / script.rate - APART_S
        found.append((first, last, name.removesuffix(" again")))
    return found


def shown(script) -> list[int]:
    """Frames for the preview: the middle of the calm part and of every expression's second time."""
    cues = [script.cues[0], *(cue for cue in script.cues if cue[0].endswith("again"))]
    return [(start + end) // 2 for _, start, end in cues]


def add_truth(report, score, truth, tracked, eyes) -> None:
    """Errors beside the frozen baseline; weights beside MediaPipe's own."""
    report.heading("Against the truth").text(
        "The performer is nobody the identity space knows, and makes every expression in their own way. The frozen "
        "baseline is the right person in the right pose with one fixed mean expression. Vertices slide along smooth "
        "skin, where depth shows nothing: their error is larger than the surface's. Frames in which the hand hides the "
        "face count like all others."
    )
    ours, theirs = weight_errors(truth, tracked, eyes)
    rows = [
        *score.rows(),
        ("head's turn, mean", f"{np.degrees(score.rotation.mean()):.2f}°", "", ""),
        ("weights, mean absolute error", f"{ours:.3f}", "", ""),
        ("the same, MediaPipe's own scores", f"{theirs:.3f}", "", ""),
    ]
    report.table(rows, ("", "result", "frozen", "ratio"))


def weight_errors(truth, tracked, eyes) -> tuple[float, float]:
    """Mean absolute error of our weights, and of the landmarker's scores on the same frames."""
    performance, names = tracked.performance, truth.actor.names
    found = [eyes.found.get(time) for time in sorted(eyes.found)]
    both = [i for i, marks in enumerate(found) if marks is not None and performance.tracked[i]]
    columns = [performance.rig.index(name) for name in names]
    ours = performance.weights[both][:, columns]
    theirs = np.array([[found[i].scores[name] for name in names] for i in both])
    true = truth.weights[both]
    return mean_error(ours, true), mean_error(theirs, true)


def mean_error(found: np.ndarray, true: np.ndarray) -> float:
    """Mean absolute difference."""
    return float(np.abs(found - true).mean())


def add_stages(report, study, truth) -> None:
    """The paper's fig. 5: every tracker's errors, and their faces in the strongest frame of the second half."""
    from ..reports.tracking import faces_sheet

    in_view = np.flatnonzero(truth.in_view)
    scores = {name: variant_score(study, name, truth, in_view[::2]) for name in study.variants}
    first = next(iter(scores.values()))
    frame = telling(first, truth)
    moved = truth.vertices(np.array([frame]))[0]
    errors = {name: expression_error(study, name, truth, frame) for name in study.variants}
    rest = np.where(face(), np.linalg.norm(moved - truth.neutral.vertices, axis=1), np.nan)
    cells = [("the truth", moved, None), ("its way from rest", moved, rest)]
    for name, values in errors.items():
        vertices = study.vertices(name, frame)
        cells += [(name, vertices, None), ("", vertices, values)]
    report.heading("Leaving stages out, one by one (fig. 5 of the paper)").figure(
        faces_sheet(study.model.rig, cells, _round_up(np.nanpercentile(list(errors.values()), 98))),
        f"The frame at {frame / truth.rate:.2f} s, the strongest expression of the second half. In colours: how far "
        "each vertex's displacement from rest is from the true one, mm.",
    )
    rows = []
    for name, score in scores.items():
        row = (
            name,
            f"{score.expression.mean():.3f}",
            f"{score.ratio:.0%}",
            f"{score.ratio_strongest:.0%}",
            f"{score.surface:.3f}",
            f"{np.nanmean(errors[name]):.2f}",
        )
        rows.append(row)
    report.table(
        rows, ("", "expression, mm", "of frozen", "strongest tenth", "surface, mm", "this frame, mm"),
        "Frames in which the hand hides the face are left out.",
    )  # fmt: skip


def telling(score, truth) -> int:
    """The strongest frame of the second half with no hand near in time."""
    clear = minimum_filter(truth.in_view, size=31)
    late = score.frames > len(truth) / 2
    strength = np.where(clear[score.frames] & late, score.strength, -1.0)
    strongest = np.argmax(strength)
    return int(score.frames[strongest])


def variant_score(study, name: str, truth, frames):
    """The usual score of one of the study's trackers."""
    from ..stage import score_vertices

    variant = study.variants[name]
    return score_vertices(
        vertices=lambda some: np.stack([study.vertices(name, t) for t in some]),
        neutral=study.model.rig.neutral.vertices,
        T_world_face=variant.T_camera_face,
        truth=truth,
        frames=frames,
    )


def expression_error(study, name: str, truth, frame: int) -> np.ndarray:
    """(n,) |R (S - S0) - (V - V0)| in one frame, mm; NaN off the face."""
    variant = study.variants[name]
    R = truth.T_lab_face.rotation[frame].T @ variant.T_camera_face.rotation[frame]
    told = (study.vertices(name, frame) - study.model.rig.neutral.vertices) @ R.T
    true = truth.vertices(np.array([frame]))[0] - truth.neutral.vertices
    return np.where(face(), np.linalg.norm(told - true, axis=1), np.nan)


def face() -> np.ndarray:
    """Mask (n,) of the vertices that are scored."""
    from ..faces import load_face

    return load_face().regions["face"] > 0.5


def add_learning(report, study, tracked, script) -> None:
    """The paper's fig. 7, how well the learnt space says a new expression, and a table beside fig. 11."""
    from ..experiments.tracking_ablation import FULL
    from ..reports.tracking import faces_sheet

    if not study.learnt:
        report.text("No frame was far enough from the blendshapes to teach a corrective.")
        return
    first, last = _most_learnt(study, script)
    name, start, end = first
    quarter = (end - start) // 4  # off the ends, where blinks and the next expression are
    middle = tracked.to_anchors[start + quarter : end - quarter]
    apex = start + quarter + int(np.nanargmax(middle))
    moments = {
        "blendshapes alone": None,
        "known before": study.known_by(start),
        "known at this moment": study.known_by(apex),
        "known once it was over": study.known_by(end),
        "known at the end": study.known_by(last),
    }
    whole = study.vertices(FULL, apex)
    errors = {told: off_space(study, apex, space) for told, space in moments.items()}
    limit = _round_up(np.nanpercentile(errors["blendshapes alone"], 99))
    cells = [(f"{name}, {apex / script.rate:.2f} s", whole, None)]
    cells += [(told, whole, values) for told, values in errors.items()]
    report.heading("What the correctives learn (fig. 7 of the paper)").figure(
        faces_sheet(study.model.rig, cells, limit, columns=3),
        "How far the final mesh of one frame is from what the blendshapes and the correctives can say, mm, with the "
        "correctives as they were at several moments of the take. The same few correctives serve all expressions: what "
        "is learnt later takes a little from what was known.",
    )
    report.table(
        list(learning_rows(script, tracked)),
        ("expression", "to the anchors, most", "to the adaptive space, most", "taken up by the correctives"),
        "Every expression, the first time and again.",
    )


def learning_rows(script, tracked):
    """A row for every expression with depth: how far from the anchors, from the adaptive space, and what was learnt."""
    for cue, start, end in script.cues:
        before = tracked.to_anchors[start:end]
        after = tracked.to_adaptive[start:end]
        if not np.isfinite(before).any():
            continue
        left = np.nanmean(after) / np.nanmean(before)
        yield cue, f"{np.nanmax(before):.2f} mm", f"{np.nanmax(after):.2f} mm", f"{1 - left:.0%}"


def off_space(study, frame: int, correctives) -> np.ndarray:
    """(n,) what the adaptive space with these correctives cannot say of a frame's final mesh, mm; NaN off the front."""
    model = study.model
    values = np.full(len(model.rig.neutral.vertices), np.nan)
    outside = study.outside(frame, correctives)
    values[model.front] = np.linalg.norm(outside, axis=1)
    return values


def _most_learnt(study, script) -> tuple[tuple[str, int, int], int]:
    """The cue of the first round whose apex the end's correctives say so much better than those before it."""
    last = study.learnt[-1][0] + 1
    best, gain = script.cues[1], -np.inf
    for cue in script.cues[1:]:
        _, start, end = cue
        middle = (start + end) // 2
        before = study.outside(middle, study.known_by(start))
        after = study.outside(middle, study.known_by(last))
        gone = (before**2).sum(1) - (after**2).sum(1)
        drop = float(study.model.share @ gone)
        if not cue[0].endswith("again") and drop > gain:
            best, gain = cue, drop
    return best, last


def _round_up(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= value))
