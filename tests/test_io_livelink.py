"""Live Link Face CSV: by hand, round trips, the app's own recording, refusals."""

import gzip
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from mien.errors import BadInput
from mien.io.livelink import EYES, HEAD, SHAPES, eye_angles, head_angles, read_live_link, write_live_link
from mien.mesh import Mesh
from mien.rig import Performance, Rig
from mien.transforms import Transform, rotation_from_vector

REAL = Path(__file__).resolve().parents[2] / "shared/data/live_link/dao.gesichter"
NAMES = tuple(name[0].lower() + name[1:] for name in SHAPES)


def rig(names: tuple[str, ...] = NAMES) -> Rig:
    return Rig(Mesh(np.eye(3), np.array([[0, 1, 2]])), np.zeros((len(names), 3, 3)), names)


def performance(frames: int = 150, rate: float = 60.0, names: tuple[str, ...] = NAMES) -> Performance:
    rng = np.random.default_rng(0)
    turns = rotation_from_vector(rng.normal(0, 0.2, (frames, 3)))
    pose = Transform(turns, rng.normal(0, 50, (frames, 3)))
    return Performance(rig(names), rng.random((frames, len(names))), pose, rate, np.ones(frames, bool))


def turned(vector: list[float]) -> np.ndarray:
    pose = Transform(rotation_from_vector(np.array([vector])), np.zeros((1, 3)))
    return head_angles(Performance(rig(), np.zeros((1, 52)), pose, 60.0, np.ones(1, bool)), centre=False)[0]


def refusal(path: Path, text: str | None = None) -> str:
    if text is not None:
        path.write_text(text)
    with pytest.raises(BadInput) as caught:
        read_live_link(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_header_is_the_apps(tmp_path):
    write_live_link(tmp_path / "a.csv", performance(3))
    header = (tmp_path / "a.csv").read_text().splitlines()[0].split(",")
    assert header[:4] == ["Timecode", "BlendShapeCount", "EyeBlinkLeft", "EyeLookDownLeft"]
    assert header[-10:] == ["TongueOut", *HEAD, *EYES]
    assert len(header) == 63
    assert (tmp_path / "a.csv").read_text().splitlines()[1].startswith("00:00:00:00.000,61,")


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0, 120.0, 37.0])
def test_round_trip(tmp_path, rate):
    before = performance(rate=rate)
    write_live_link(tmp_path / "a.csv", before, centre=False)
    take = read_live_link(tmp_path / "a.csv")
    assert (take.rate, take.names) == (rate, NAMES)
    after = take.to_performance(before.rig)
    np.testing.assert_allclose(after.weights, before.weights, atol=1e-7)
    np.testing.assert_allclose(after.T_world_face.rotation, before.T_world_face.rotation, atol=1e-7)
    assert after.tracked.all()


def test_signs_of_head_angles_by_hand():
    np.testing.assert_allclose(turned([0, 0.3, 0]), [0.3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(turned([0.3, 0, 0]), [0, -0.3, 0], atol=1e-12)
    np.testing.assert_allclose(turned([0, 0, 0.3]), [0, 0, -0.3], atol=1e-12)


def test_centred_yaw_looks_ahead_on_average():
    before = performance()
    about = rotation_from_vector(np.array([0.0, 2.0, 0.0]))
    pose = Transform(about @ before.T_world_face.rotation, np.zeros((150, 3)))
    elsewhere = Performance(before.rig, before.weights, pose, 60.0, before.tracked)
    np.testing.assert_allclose(head_angles(elsewhere), head_angles(before), atol=1e-9)
    assert abs(head_angles(elsewhere)[:, 0].mean()) < 0.02
    assert head_angles(elsewhere, centre=False)[:, 0].mean() > 1.5


def test_eyes_follow_their_weights():
    weights = {name: np.zeros(1) for name in NAMES} | {"eyeLookOutLeft": np.ones(1), "eyeLookInRight": np.ones(1)}
    np.testing.assert_allclose(np.degrees(eye_angles(weights)), [[-35, 0, 0, -35, 0, 0]], atol=1e-12)
    weights = {name: np.zeros(1) for name in NAMES} | {"eyeLookUpLeft": np.ones(1), "eyeLookDownRight": np.ones(1)}
    np.testing.assert_allclose(np.degrees(eye_angles(weights)), [[0, -35, 0, 0, 35, 0]], atol=1e-12)


def test_shapes_are_met_by_name(tmp_path):
    few = performance(80, names=("wink", "tongueOut", "jawOpen"))
    write_live_link(tmp_path / "a.csv", few)
    take = read_live_link(tmp_path / "a.csv")
    np.testing.assert_allclose(take.weights[:, take.names.index("jawOpen")], few.weights[:, 2], atol=1e-7)
    assert take.weights[:, take.names.index("jawLeft")].max() == 0
    back = take.to_performance(few.rig)
    np.testing.assert_allclose(back.weights, few.weights * [0, 1, 1], atol=1e-7)


def hand(rows: list[str]) -> str:
    return "\n".join(["Timecode,BlendShapeCount,JawOpen,EyeBlinkLeft,HeadYaw", *rows])


def test_frames_left_out_or_without_a_face_hold_the_last_value(tmp_path):
    rows = [
        "10:00:01:28.100,61,0.1,0,0.5", "10:00:01:29.100,0,,,", "10:00:02:00.100,61,0.3,0,0.5",
        "10:00:02:03.100,61,0.4,0,0.5", *(f"10:00:02:{i:02d}.100,61,0.5,0,0.5" for i in range(4, 30)),
    ]  # fmt: skip
    (tmp_path / "a.csv").write_text(hand(rows))
    take = read_live_link(tmp_path / "a.csv")
    assert take.rate == 30
    np.testing.assert_allclose(take.weights[:7, take.names.index("jawOpen")], [0.1, 0.1, 0.3, 0.3, 0.3, 0.4, 0.5])
    np.testing.assert_array_equal(take.tracked[:7], [True, False, True, False, False, True, True])
    np.testing.assert_allclose(take.head[:, 0], 0.5)


def test_every_second_frame_of_the_time_code(tmp_path):
    rows = [f"10:00:{1 + i // 30:02d}:{i % 30 * 2:02d}.000,61,0.5,0,0" for i in range(70)]
    (tmp_path / "a.csv").write_text(hand(rows))
    take = read_live_link(tmp_path / "a.csv")
    assert (take.rate, len(take.weights), take.tracked.all()) == (30, 70, True)
    assert read_live_link(tmp_path / "a.csv", rate=29.97).rate == 29.97


def test_without_time_codes_frames_follow_one_another(tmp_path):
    (tmp_path / "a.csv").write_text(hand(["x,61,0.5,0,0", "x,61,0.6,0,0"]))
    take = read_live_link(tmp_path / "a.csv")
    assert (take.rate, len(take.weights)) == (60, 2)


def test_refusals(tmp_path):
    path = tmp_path / "a.csv"
    assert "no such file" in refusal(path)
    assert "no Live Link Face CSV" in refusal(path, "")
    assert "no Live Link Face CSV" in refusal(path, "a,b,c\n1,2,3\n")
    assert "no frames" in refusal(path, hand([]))
    assert "no number" in refusal(path, hand(["00:00:00:01.0,61,oops,0,0"]))
    assert "no frame in which a face was seen" in refusal(path, hand(["00:00:00:01.0,0,,,"]))
    with pytest.raises(BadInput, match="no ARKit shape"):
        write_live_link(path, performance(names=("smile", "frown")))
    path.write_text(hand(["00:00:00:01.0,61,0.5,0,0"]))
    with pytest.raises(BadInput, match="no ARKit shape"):
        read_live_link(path).to_performance(rig(("smile", "frown")))


# --- what other programs write ------------------------------------------------------------------------------------


def dialect(tmp_path, change, rate: float = 30.0):
    """A take of 60 frames, written as the app does, its text changed, and read."""
    rng = np.random.default_rng(1)
    turns = rotation_from_vector(0.2 * np.sin(np.arange(60) / 10)[:, None] * [1.0, 0.5, 0.2])
    weights = 0.5 * rng.random((60, 52))
    before = Performance(rig(), weights, Transform(turns, np.zeros((60, 3))), rate, np.ones(60, bool))
    write_live_link(tmp_path / "plain.csv", before, centre=False)
    (tmp_path / "other.csv").write_bytes(change((tmp_path / "plain.csv").read_text()))
    return read_live_link(tmp_path / "plain.csv"), read_live_link(tmp_path / "other.csv")


def cells(text: str, change) -> bytes:
    """The text with every cell (column name, value) of its rows changed."""
    header, *rows = [line.split(",") for line in text.splitlines()]
    changed = [[change(name, cell) for name, cell in zip(header, row, strict=True)] for row in rows]
    return "\n".join(",".join(row) for row in [header, *changed]).encode()


def turns_of(name: str) -> bool:
    return name in (*HEAD, *EYES)


def weight_of(name: str) -> bool:
    return name in SHAPES


DIALECTS = {
    "degrees": lambda t: cells(t, lambda n, c: f"{np.degrees(float(c)):.8f}" if turns_of(n) else c),
    "percent": lambda t: cells(t, lambda n, c: f"{100 * float(c):.8f}" if weight_of(n) else c),
    "drop-frame": lambda t: cells(t, lambda n, c: ";".join(c.rsplit(":", 1)) if n == "Timecode" else c),
    "seconds": lambda t: cells(
        t, lambda n, c: f"{int(c.split(':')[2]) + float(c.split(':')[3]) / 30:.4f}" if n == "Timecode" else c
    ),
    "_L": lambda t: t.replace("Left,", "_L,").replace("Right,", "_R,").replace("Jaw_", "jaw_").encode(),
    "snake": lambda t: re.sub(r"(?<=[a-z])([A-Z])", r"_\1", t.splitlines()[0]).lower().encode()
    + b"\n" + "\n".join(t.splitlines()[1:]).encode(),
    "semicolons and decimal commas": lambda t: t.replace(",", ";").replace(".", ",").encode(),
    "tabs, UTF-16": lambda t: t.replace(",", "\t").encode("utf-16"),
    "byte-order mark": lambda t: t.encode("utf-8-sig"),
    "other order": lambda t: "\n".join(",".join(line.split(",")[::-1]) for line in t.splitlines()).encode(),
}  # fmt: skip


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects_say_the_same_and_guesses_are_told(tmp_path, name):
    plain, other = dialect(tmp_path, DIALECTS[name])
    assert plain.notes == ()
    assert other.rate == pytest.approx(30, abs=1e-3)
    assert other.names == plain.names
    np.testing.assert_allclose(other.weights, plain.weights, atol=1e-6)
    np.testing.assert_allclose(other.head, plain.head, atol=1e-6)
    np.testing.assert_allclose(other.eyes, plain.eyes, atol=1e-6)
    told = {"degrees": "degrees", "percent": "percent", "drop-frame": "drop-frame", "seconds": "seconds",
            "_L": "matched loosely", "snake": "matched loosely"}  # fmt: skip
    if name in told:
        assert told[name] in " ".join(other.notes)


def test_a_drop_frame_minute_has_no_gap(tmp_path):
    codes = [f"00:00:59;{f:02d}" for f in range(20, 30)] + [f"00:01:00;{f:02d}" for f in range(2, 30)]
    codes += [f"00:01:01;{f:02d}" for f in range(30)]
    (tmp_path / "a.csv").write_text(hand([f"{code},61,0.5,0,0" for code in codes]))
    take = read_live_link(tmp_path / "a.csv")
    assert (len(take.weights), take.tracked.all()) == (68, True)
    assert take.rate == pytest.approx(30000 / 1001)


def test_repeated_rows_and_gaps_are_told(tmp_path):
    frames = [0, 1, 1, 2, 5, *range(6, 30), *range(30, 60)]
    rows = [f"10:00:{f // 30:02d}:{f % 30:02d}.000,61,{f / 100},0,0" for f in frames]
    (tmp_path / "a.csv").write_text(hand(rows))
    take = read_live_link(tmp_path / "a.csv")
    assert len(take.weights) == 60
    assert "1 rows repeat a time" in " ".join(take.notes)
    assert "2 frames have no row" in " ".join(take.notes)
    np.testing.assert_allclose(take.weights[:6, take.names.index("jawOpen")], [0, 0.01, 0.02, 0.02, 0.02, 0.05])


def test_nonsense_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"10:00:00:{i:02d}.0,61,0.5,0,0.1" for i in range(30)]
    assert "neither 0..1 nor percent" in refusal(path, hand([*rows, "10:00:01:00.0,61,5000,0,0"]))
    assert "neither 0..1 nor percent" in refusal(path, hand([*rows, "10:00:01:00.0,61,-3,0,0"]))
    assert "neither radians nor degrees" in refusal(path, hand([*rows, "10:00:01:00.0,61,0.1,0,900"]))


def test_a_rig_with_other_names_plays_it(tmp_path):
    before = performance(80)
    write_live_link(tmp_path / "a.csv", before, centre=False)
    take = read_live_link(tmp_path / "a.csv")
    spelled = rig(tuple(f"blendShape1.{name}" for name in NAMES))
    np.testing.assert_allclose(take.to_performance(spelled).weights, before.weights, atol=1e-7)
    few = rig(("Mund", "x"))
    np.testing.assert_allclose(
        take.to_performance(few, {"Mund": "jawOpen"}).weights[:, 0],
        before.weights[:, NAMES.index("jawOpen")],
        atol=1e-7,
    )


def test_weights_written_lie_within_bounds(tmp_path):
    wide = performance(70)
    wide = Performance(wide.rig, 3 * wide.weights - 1, wide.T_world_face, 60.0, wide.tracked)
    write_live_link(tmp_path / "a.csv", wide)
    found = read_live_link(tmp_path / "a.csv").weights
    np.testing.assert_allclose(found, np.clip(wide.weights, 0, 1), atol=1e-7)


# --- the app's own recording -------------------------------------------------------------------------------------

PACKET_ORDER = list(SHAPES)
for one, other in (("JawRight", "JawLeft"), ("MouthRight", "MouthLeft")):
    i = PACKET_ORDER.index(one)
    PACKET_ORDER[i : i + 2] = [other, one]


def decoded() -> tuple[list[tuple[int, float, int]], np.ndarray]:
    """Time codes (frame, its fraction, rate) and values of the recorded packets."""
    data = gzip.decompress(REAL.read_bytes())
    count = int.from_bytes(data[1:5], "big")
    codes, values, at = [], [], 5
    for _ in range(count):
        size = int.from_bytes(data[at : at + 4], "big")
        packet, at = data[at + 4 : at + 4 + size], at + 4 + size
        place = 1
        for _ in range(2):
            place += 4 + int.from_bytes(packet[place : place + 4], "big")
        frame, fraction, rate, _, k = struct.unpack_from(">IfIIB", packet, place)
        codes.append((frame, fraction, rate))
        values.append(struct.unpack_from(f">{k}f", packet, place + 17))
    assert at == len(data)
    return codes, np.array(values)


@pytest.mark.data
def test_a_real_recording(tmp_path):
    """Written as the app writes its CSV: it reads back frame by frame, and its eyes obey our formula."""
    if not REAL.exists():
        pytest.skip(f"{REAL} is not there")
    codes, values = decoded()
    assert values.shape == (180, 61)
    lines = [",".join(["Timecode", "BlendShapeCount", *PACKET_ORDER, *HEAD, *EYES])]
    for (frame, fraction, rate), row in zip(codes, values, strict=True):
        s, f = divmod(frame, rate)
        code = f"{s // 3600:02d}:{s // 60 % 60:02d}:{s % 60:02d}:{f:02d}.{int(fraction * 1000):03d}"
        lines.append(",".join([code, "61", *(f"{v:.8f}" for v in row)]))
    (tmp_path / "dao.csv").write_text("\n".join(lines))
    take = read_live_link(tmp_path / "dao.csv")
    assert take.rate == 60
    assert take.tracked.sum() == 180
    assert len(take.weights) == codes[-1][0] - codes[0][0] + 1
    order = [PACKET_ORDER.index(name) for name in SHAPES]
    np.testing.assert_allclose(take.weights[take.tracked], values[:, order], atol=1e-7)
    np.testing.assert_allclose(take.head[take.tracked], values[:, 52:55], atol=1e-7)
    # The app's eyes turn with their weights; its axes are off ours by a few degrees all the way.
    ours = eye_angles(dict(zip(take.names, take.weights.T, strict=True)))[:, [0, 1, 3, 4]]
    off = take.eyes[:, [0, 1, 3, 4]] - ours
    assert np.abs(off - off.mean(axis=0)).max() < np.radians(0.5)
    assert np.abs(off.mean(axis=0)).max() < np.radians(5)
