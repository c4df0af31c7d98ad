"""Switch every named step of the pipelines off, one by one, and list what no test misses.

`python tools/mutants.py [WORD ...]` runs those whose line holds one of the words, all without. A step is switched off
by a stand-in (`tools/mutant_plugin.py`), and the nearest tests run until the first that fails: the test file of the
step's module, or those that stand after `|`. Exit status 1 where a step is missed by none.
"""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
LIMIT_S = 600
"""A mutant whose tests take longer counts as missed: it hangs."""

STEPS = """
takes.stabilise:stabilise = replace(r, markers=a['markers']) | test_takes* test_markers_take*
takes.gaps:fill_gaps = a['positions'] | test_takes* test_markers_take*
takes.depth_reliability:depth_metric = replace(r, metric=np.eye(3)) | test_takes* test_markers_take*
takes.world:turn_y_up = a['T_lab_face'] | test_takes* test_markers_take*
takes.outliers:remove_outliers = replace(r, markers=a['markers']) | test_takes_outliers* test_markers_pipeline*
markers.refine_attachment:refine_attachment = a['fit'].attachment | test_markers_refine* test_markers*
markers.pipeline:fit_neutral_to_markers = a['calibration'].rig | test_markers*
markers.personalise_shapes:personalise_shapes = a['rig'] | test_markers*
markers.pipeline:TakeConfig.personalise_rounds = 0 | test_markers*
scans.take_in_head:preprocess_take = a['markers'] | test_scans_take_in_head* test_scans_pipeline* test_takes*
scans.take_in_head:neutral_first = list(a['scans']) | test_scans_take_in_head* test_scans_pipeline*
scans.marker_consensus:consensus_attachment = a['template'].attachment_of(a['shapes'][0], a['skin_points'][0])|test_sca*
scans.marker_consensus:consensus_standoff = a['standoff'] | test_scans*
scans.reconstruct:meet_markers = a['shapes'] | test_scans*
scans.correspond.fine_scale:register_fine = replace(r, vertices=a['shapes']) | test_scans*
scans.correspond.still_skin:settle_heads = [r[0] for _ in r] | test_scans_correspond*
scans.scan_colours:rig_colours = None | test_scans_scan*
fitting.register_scan:_believed = a['anchors'] | test_fitting*
fitting.register_scan:_refined = (a['mesh'], a['body'].trusted(a['config'].off_face)) | test_fitting_register_scan*
tracking.tracker:carry_landmarks = a['observation'] | test_tracking*
tracking.tracker:remove_standing_errors = a['observation'] | test_tracking*
tracking.tracker:rigid_motion = replace(r, T_camera_face=a['T_camera_face']) | test_tracking*
tracking.tracker:adaptive_space = (None, a['v1']) | test_tracking*
tracking.tracker:output_deformation = a['v3'] | test_tracking*
tracking.tracker:learn_standing_errors = (a['state'].landmark_bias, a['state'].baseline) | test_tracking*
tracking.tracker:weights_anew = a['fitted'] | test_tracking*
tracking.tracker:damped = a['T_camera_face'] | test_tracking*
tracking.tracker:learn_correctives = replace(r, correctives=a['state'].correctives) | test_tracking*
tracking.fit:refine_pose = a['T_camera_face'] | test_tracking_fit* test_tracking*
tracking.terms.fit_config:BlendshapeFitConfig.head_relative_landmarks = False | test_tracking*
tracking.terms.fit_config:BlendshapeFitConfig.l1_per_mm = 0.0 | test_tracking*
tracking.terms.photometric:PhotometricConfig.weight = 0.0 | test_tracking_terms_photometric* test_tracking*
tracking.tracker:finite = True | test_tracking*
detail.drive:drive_by_performance = replace(r, positions=r.positions * 0 + r.positions[:1]) | test_detail*
detail.drive:drive_by_markers = replace(r, positions=r.positions * 0 + r.positions[:1]) | test_detail*
detail.training:head_markers = replace(r, steadiness=np.ones_like(r.steadiness)) | test_detail*
rig.head_place:place_motion = (a['T_world_face'], []) | test_retarget* test_rig*
rig.retarget:_with_transferred = a['target'] | test_retarget* test_rig*
rig.unit_weights:with_unit_weights = a['performance'] | test_rig* test_io_gltf*
"""
"""A line a step: `module:function = result | test files`, or `module:Config.field = value | test files`.

In a result, `a` holds the arguments by name and `r` is the step's own result.
"""


def test_files(line: str) -> list[str]:
    """The tests that are nearest to a step."""
    place, _, told = line.partition("|")
    module = place.partition(":")[0].strip().replace(".", "_").replace("__", "_")
    patterns = told.split() or [f"test_{module}*"]
    return sorted({str(path) for pattern in patterns for path in (HERE / "tests").glob(f"{pattern}.py")})


def outcome(line: str) -> str:
    """`noticed`, `MISSED`, `no tests`, or why the step could not be switched off."""
    files = test_files(line)
    if not files:
        return "no tests"
    environment = {**os.environ, "MIEN_MUTANT": line.partition("|")[0].strip()}
    environment["PYTHONPATH"] = os.pathsep.join([str(HERE / "src"), str(HERE / "tools")])
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "mutant_plugin", *files]
    try:
        done = subprocess.run(command, cwd=HERE, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return "MISSED (tests do not end)"
    if done.returncode == 1:
        return "noticed"
    return "MISSED" if done.returncode == 0 else f"cannot be run: {(done.stderr or done.stdout).strip()[-300:]}"


def main(words: list[str]) -> int:
    """Run them, printing as they come; how many no test missed."""
    lines = [line for line in STEPS.strip().splitlines() if not words or any(word in line for word in words)]
    missed = 0
    for line in lines:
        told = outcome(line)
        missed += told != "noticed"
        print(f"{told:<10} {line.partition('|')[0].strip()}", flush=True)
    print(f"{len(lines) - missed} of {len(lines)} steps are missed by a test when they are switched off")
    return missed


if __name__ == "__main__":
    sys.exit(bool(main(sys.argv[1:])))
