"""Active light: base geometry, normals and the fused surface against the truth, still and moving, as a table.

`python benchmarks/light.py [--seeds 501 502] [--kind bent|stranger] [--only still]`: two cameras of 768 x 1024 before a
staged skin of about 190,000 vertices. A moving face goes by 4 mm and through an eighth of a smile within one capture
(12 slots, 1/30 s). Below, errors in depth parted into bands, of the triangulated points, of the light's normals alone,
integrated, and of both fused. Beside ours: OpenCV's decoder of Gray codes on the same still face.
The first capture's times hold the compilation of what was never run on the machine.
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from mien.experiments.light_stage import LightScore, LightStageConfig, StagedCapture, score_scan, staged_capture
from mien.light.decode_phase import decode_gray
from mien.light.decode_sinusoids import DecodeConfig
from mien.light.motion import MotionConfig
from mien.light.patterns import gray_set
from mien.light.pipeline import LightConfig, light_scan, light_sources
from mien.stage import STRANGER, PerformerConfig, Skin, SkinConfig, make_performer, make_skin

SMILE = {"mouthSmileLeft": 0.6, "mouthSmileRight": 0.5, "browInnerUp": 0.8, "noseSneerLeft": 0.6, "noseSneerRight": 0.6}
MOVE = (3.0, 2.0, 2.0)
UNCOMPENSATED = LightConfig(decode=DecodeConfig(motion=False), motion=MotionConfig(compensate=False))
PAPER = LightConfig(decode=DecodeConfig(motion=False), motion=MotionConfig(to_structured=False))


def skin_of(seed: int, kind: str) -> Skin:
    performer = make_performer(seed, STRANGER if kind == "stranger" else PerformerConfig())
    return make_skin(performer, SkinConfig(levels=3, eyes_and_teeth=False), seed)


def expression(skin: Skin, amount: float) -> np.ndarray:
    weights = np.zeros(len(skin.names))
    for name, value in SMILE.items():
        weights[skin.names.index(name)] = amount * value
    return weights


def captures(skin: Skin) -> dict[str, tuple[StagedCapture, LightConfig]]:
    """Each case's pictures, and how they are decoded."""
    half, more = expression(skin, 0.5), expression(skin, 0.625)
    plain = LightStageConfig()
    shiny = replace(plain, faults=replace(plain.faults, specular=0.3))
    still = staged_capture(skin, half, half, plain)
    moving = staged_capture(skin, half, more, plain, move_mm=MOVE)
    return {
        "still": (still, LightConfig()),
        "still, highlights": (staged_capture(skin, half, half, shiny), LightConfig()),
        "moving": (moving, LightConfig()),
        "moving, as in the paper": (moving, PAPER),
        "moving, nothing compensated": (moving, UNCOMPENSATED),
    }


def row(name: str, score: LightScore, cpu_s: float, wall_s: float) -> str:
    return (
        f"| {name} | {score.geometry_mm:.3f} | {score.fused_mm:.3f} | {score.geometry_deg:.1f} | {score.light_deg:.1f} "
        f"| {score.fused_deg:.1f} | {score.share:.0%} | {cpu_s:.1f} | {wall_s:.1f} |"
    )


def against_opencv(skin: Skin) -> None:
    """Gray codes alone: our columns and OpenCV's on the same pictures."""
    try:
        import cv2
    except ImportError:
        print("OpenCV is not installed: no comparison")
        return
    half = expression(skin, 0.5)
    patterns = gray_set(1024, 768)
    capture = staged_capture(skin, half, half, LightStageConfig(), patterns)
    images = capture.images["left"]
    truth = true_columns(capture)
    start = time.perf_counter()
    ours = decode_gray(images, patterns).pixel
    ours_s = time.perf_counter() - start
    peer = cv2.structured_light.GrayCodePattern.create(1024, 768)
    eight = [np.ascontiguousarray((255 * image).astype(np.uint8)) for image in images]
    start = time.perf_counter()
    theirs = np.full(truth.shape, np.nan)
    codes = eight[:-2]
    for y, x in zip(*np.nonzero(np.isfinite(truth)), strict=True):
        bad, place = peer.getProjPixel(codes, int(x), int(y))
        if not bad:
            theirs[y, x] = place[0]
    theirs_s = time.perf_counter() - start
    means = []
    for name, found, seconds in (("ours", ours, ours_s), ("OpenCV", theirs, theirs_s)):
        off = np.abs(found - truth)
        off = off[np.isfinite(off)]
        means.append(off.mean())
        print(f"Gray codes, {name}: {off.mean():.3f} projector pixels off on {len(off):,} pixels, {seconds:.2f} s")
    print(f"OpenCV's is {means[1] / means[0]:.1f} times as far off and takes {theirs_s / ours_s:.0f} times as long")


def true_columns(capture: StagedCapture) -> np.ndarray:
    """The projector's column at each pixel of the first camera."""
    from mien.stage.sensors.active_light import Placed, look

    view, projector = capture.rig.cameras[0], capture.rig.projector
    seen = look(capture.truth(0), Placed(view.camera, view.T_view_rig))
    columns = np.full(seen.mask.shape, np.nan)
    columns[seen.mask] = projector.camera.project(projector.T_view_rig.apply(seen.points))[:, 0]
    return columns


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seeds", type=int, nargs="+", default=[501])
    words.add_argument("--kind", choices=["bent", "stranger"], default="bent")
    words.add_argument("--only", default="")
    told = words.parse_args()
    for seed in told.seeds:
        skin = skin_of(seed, told.kind)
        print(f"\nperformer {seed}, {told.kind}")
        print("| case | points, mm | fused, mm | points' normals | light's | fused, degrees | share | CPU s | wall s |")
        print("|---|---|---|---|---|---|---|---|---|")
        bands = {}
        for name, (capture, config) in captures(skin).items():
            if told.only not in name:
                continue
            start = time.process_time(), time.perf_counter()
            sources = light_sources(capture.images, capture.patterns, capture.rig, config)
            scan = light_scan(sources, config.fuse)
            taken = time.process_time() - start[0], time.perf_counter() - start[1]
            score = score_scan(scan, sources, capture, config)
            bands[name] = score.bands
            print(row(name, score, *taken), flush=True)
        print("\n| case | source | finer than 0.5 mm | 0.5 to 2 mm | 2 to 8 mm | broader |")
        print("|---|---|---|---|---|---|")
        for name, told_by in bands.items():
            for source in ("points", "light", "fused"):
                print(f"| {name} | {source} | {' | '.join(f'{off:.3f}' for off in told_by[source])} |")
        if told.only in "opencv":
            against_opencv(skin)


if __name__ == "__main__":
    main()
