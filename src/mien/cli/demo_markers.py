"""`mien demo markers`: a staged take, solved and scored."""

from pathlib import Path


def demo_markers(folder: Path, seed: int, seconds: float, count: int) -> None:
    """Leaves take.c3d, perf.glb, preview.png and report.html in `folder`."""
    from ..faces import load_face
    from ..io.gltf import write_performance
    from ..io.markers import read_markers, write_c3d
    from ..markers.pipeline import solve_take
    from ..pictures import write_png
    from ..reports.markers import preview, take_report
    from ..reports.verdict import truth_verdict
    from ..stage import make_performer, marker_layout, perform, score_performance, scripted
    from ..viewer.moving_page import ALIVE, moving_page
    from .bar import bar
    from .solve import summary

    with bar() as progress:
        progress.update("staging a performance", 0, 2)
        performer = make_performer(seed)
        script = scripted(rate=60.0, seconds=seconds)
        progress.update("staging a performance", 1, 2)
        take = perform(performer, script.weights, 60.0, marker_layout(performer, count), seed=seed)
        write_c3d(folder / "take.c3d", take.markers)
        progress.update("staging a performance", 2, 2)
        recorded = read_markers(folder / "take.c3d")
        solved = solve_take(recorded, load_face(), progress=progress)
        write_performance(folder / "perf.glb", solved.performance)
        picture = preview(solved, progress=progress)
        write_png(folder / "preview.png", picture)
        progress.update("scoring against the truth", 0, 1)
        score = score_performance(solved.performance, take.truth)
        moving = moving_page(solved.performance, "perf.glb", opening=ALIVE)
        verdict = truth_verdict(score.ratio, score.ratio_strongest)
        report = take_report("take.c3d", solved, picture, [verdict], moving)
        report.heading("Against the truth").text(
            "The performer is nobody the identity space knows, and makes every expression in their own way. The frozen "
            "baseline is the right person in the right pose with one fixed mean expression."
        )
        report.table(score.rows(), ("", "result", "frozen", "ratio"))
        report.write(folder / "report.html")
        progress.update("scoring against the truth", 1, 1)
    print(summary(solved))
    print(verdict)
    print(f"{folder}/: take.c3d  perf.glb  preview.png  report.html (open it: the face moves there)")
    print(f"next: mien view {folder}/perf.glb {folder}/take.c3d")
