"""The table of muscles is whole: every unit has its muscles, every muscle its field."""

from mien.faces.arkit import ARKIT_NAMES
from mien.stage import STRANGER, make_performer
from mien.stage.people.muscle_table import DRIVE, MIDDLE_PULLS, PAIRED_DRIVE, PULLS

BY_ANGLE = ("eyeLook", "jawOpen", "mouthClose")
"""Units that turn parts instead of drawing skin."""


def test_every_unit_has_muscles_and_every_muscle_is_used():
    sided = {f"{unit}{side}" for unit in PAIRED_DRIVE for side in ("Left", "Right")}
    asked = sided | set(DRIVE)
    assert {name for name in ARKIT_NAMES if not name.startswith(BY_ANGLE)} == asked
    drawn = {muscle for table in (*DRIVE.values(), *PAIRED_DRIVE.values()) for muscle in table}
    bare = {m.removesuffix("Left").removesuffix("Right") for m in drawn}
    assert set(PULLS) | set(MIDDLE_PULLS) <= bare


def test_there_are_some_thirty_muscles_or_more():
    motion = make_performer(1, STRANGER).motion
    assert 30 <= len(motion.muscles) <= 50
    assert (motion.drive.max(axis=0) > 0).all()
