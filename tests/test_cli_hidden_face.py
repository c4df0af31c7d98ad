"""`mien track --hidden upper` from files: gauges drive what is hidden; what does not go together is said at once."""


import numpy as np
import pytest

import tracking_stage as stage
from mien.cli.main import main
from mien.io.gltf import read_performance, write_performance
from mien.rig import Performance
from mien.transforms import Transform
from rgbd_study import FRAMES, track_shell

CALIBRATION_FRAMES, RATE = 240, 30.0


@pytest.fixture
def shell(tmp_path, monkeypatch, capsys):
    """The shell, and tables of one gauge that reads the brow: 5 mV at rest, 6 raised."""
    folder, told, call = track_shell(tmp_path, monkeypatch, capsys)
    rig = stage.person()
    weights = np.zeros((CALIBRATION_FRAMES, len(rig.names)))
    brow = np.sin(np.arange(CALIBRATION_FRAMES) / 12.0).clip(0, 1) ** 4
    weights[:, rig.index("browInnerUp")] = brow
    still = Transform(np.tile(np.eye(3), (CALIBRATION_FRAMES, 1, 1)), np.zeros((CALIBRATION_FRAMES, 3)))
    seen = Performance(rig, weights, still, RATE, np.ones(CALIBRATION_FRAMES, bool))
    write_performance(folder / "seen.glb", seen)
    table(folder / "seen.csv", 5.0 + brow)
    table(folder / "gauges.csv", 5.0 + (np.arange(FRAMES) >= FRAMES - 4))
    return folder, told, call


def table(path, values, start=0.0):
    rows = [f"{start + t / RATE:.4f},{value:.4f}" for t, value in enumerate(values)]
    path.write_text("\n".join(["time,brow", *rows]) + "\n")


def words(folder, **given):
    files = {"gauges": "gauges.csv", "calibration": "seen.glb", "calibration-gauges": "seen.csv"} | given
    pairs = [(f"--{name}", str(folder / file)) for name, file in files.items() if file]
    return ["--hidden", "upper", *(word for pair in pairs for word in pair)]


def test_gauges_raise_the_brow_that_is_not_seen(shell, capsys):
    folder, _, _ = shell
    take = ["track", str(folder / "take"), "--rig", str(folder / "rig.glb"), "-o", str(folder / "perf.glb")]
    with pytest.raises(SystemExit) as stop:
        main([*take, *words(folder), "--picture", str(folder / "p.png")])
    assert not stop.value.code
    told = capsys.readouterr().err
    assert "browInnerUp" in told
    assert "rms error on held-out parts" in told
    made = read_performance(folder / "perf.glb")
    brow = made.weights[:, made.rig.index("browInnerUp")]
    assert brow[:6].max() < 0.1
    assert brow[-3:].min() > 0.85
    assert made.weights[:, made.rig.index("jawOpen")].max() > 0.1


def test_what_does_not_go_together_is_said(shell):
    folder, _, call = shell
    assert "go together" in call(*words(folder, calibration=None))
    assert "does nothing without --hidden upper" in call("--gauges", str(folder / "gauges.csv"))
    table(folder / "late.csv", np.arange(9.0), start=99.0)
    assert "late.csv: no reading falls into the take (readings from 99.0" in call(*words(folder, gauges="late.csv"))
    table(folder / "dead.csv", np.full(FRAMES, 5.0))
    assert "constant or empty, left out: brow" in call(*words(folder, gauges="dead.csv"))
    table(folder / "short.csv", 5.0 + np.arange(60) % 2)
    line = call(*words(folder, **{"calibration-gauges": "short.csv"}))
    assert "5 s are the least" in line
    (folder / "other.csv").write_text("time,cheek\n0,1\n1,2\n")
    assert "no channel is left that both tables have" in call(*words(folder, gauges="other.csv"))
    assert not (folder / "perf.glb").exists()
