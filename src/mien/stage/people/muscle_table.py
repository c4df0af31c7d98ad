"""Which muscles a face has, where they are fixed and what they are asked to do: anatomy as a table.

Places are numbers of MediaPipe's landmarks on the left side (the right side is mirrored), moved by an offset in mm.
After Waters 1987 (linear muscles and sphincters) and the muscles behind Ekman and Friesen's action units.
"""

from dataclasses import dataclass

from ..script.poses import both as both_sides


@dataclass(frozen=True)
class Pull:
    """A muscle from bone to skin."""

    origin: tuple[int, tuple[float, float, float]]
    """Where it is fixed: landmark and offset, mm."""
    insertion: tuple[int, tuple[float, float, float]]
    """Which skin it draws."""
    width: float
    """How far from the fibre the skin still follows, mm."""
    reach: float
    """How far the insertion is drawn, mm."""
    bulge: float = 0.0
    """How far the belly rises, mm."""


ON = (0.0, 0.0, 0.0)
PULLS: dict[str, Pull] = {
    "frontalisMedial": Pull((338, (0.0, 8.0, 0.0)), (336, ON), 20.0, 10.0, 0.4),
    "frontalisLateral": Pull((332, (0.0, 8.0, 0.0)), (334, ON), 20.0, 11.0, 0.4),
    "corrugator": Pull((168, (0.0, 3.0, 0.0)), (336, (7.0, 2.0, 0.0)), 17.0, 9.0, 1.2),
    "orbicularisOculi": Pull((450, ON), (280, ON), 21.0, 9.0, 2.6),
    "orbicularisLateral": Pull((263, ON), (356, ON), 16.0, 6.0, 0.8),
    "levatorNasi": Pull((362, (0.0, -6.0, 0.0)), (279, ON), 11.0, 7.0, 1.0),
    "levatorLabii": Pull((349, ON), (269, ON), 13.0, 8.5, 1.3),
    "zygomaticus": Pull((345, ON), (291, ON), 16.0, 15.0, 3.4),
    "risorius": Pull((435, ON), (291, ON), 15.0, 10.0, 0.8),
    "buccinator": Pull((411, (14.0, 0.0, 0.0)), (291, ON), 11.0, 7.0, -1.2),
    "depressorAnguli": Pull((291, (5.0, -30.0, -6.0)), (291, ON), 12.0, 9.0, 0.8),
    "depressorLabii": Pull((199, (17.0, -2.0, -3.0)), (405, ON), 12.0, 7.5, 0.6),
    "platysma": Pull((379, (-2.0, -26.0, -8.0)), (430, ON), 24.0, 6.0, 0.5),
}
"""Paired ones, "Left" and "Right" behind the name."""
MIDDLE_PULLS: dict[str, Pull] = {
    "procerus": Pull((197, ON), (9, ON), 16.0, 6.0, 0.8),
    "mentalis": Pull((17, ON), (199, (0.0, -3.0, 0.0)), 17.0, 7.0, 2.6),
}
JAW_FIXED = (4, 98, 327, 50, 280, 117, 346, 127, 356, 234, 454, 205, 425, 0, 37, 267, 39, 269)
"""Landmarks that the jaw does not carry."""
JAW_CARRIED = (152, 199, 175, 18, 17, 84, 314, 148, 377, 176, 400, 149, 378, 150, 379, 136, 365)
"""Landmarks that it carries whole."""

DRIVE: dict[str, dict[str, float]] = {
    "browInnerUp": {"frontalisMedialLeft": 1.0, "frontalisMedialRight": 1.0},
    "mouthFunnel": {"funnel": 1.0, **both_sides(levatorLabii=0.15, depressorLabii=0.2)},
    "mouthPucker": {"pucker": 1.0, "mentalis": 0.1},
    "mouthRollUpper": {"rollUpper": 1.0},
    "mouthRollLower": {"rollLower": 1.0, "mentalis": 0.15},
    "mouthShrugUpper": {"shrugUpper": 1.0, **both_sides(levatorNasi=0.1)},
    "mouthShrugLower": {"shrugLower": 1.0, "mentalis": 0.9},
    "mouthLeft": {"modiolusLeft": 1.0, "risoriusLeft": 0.2},
    "mouthRight": {"modiolusRight": 1.0, "risoriusRight": 0.2},
    "cheekPuff": both_sides(puff=1.0, press=0.1),
    "jawForward": {"jawForward": 1.0},
    "jawLeft": {"jawLeft": 1.0},
    "jawRight": {"jawRight": 1.0},
    "tongueOut": {"tongue": 1.0},
}
PAIRED_DRIVE: dict[str, dict[str, float]] = {
    "browDown": {"corrugator": 1.0, "procerus": 0.5, "orbicularisLateral": 0.15},
    "browOuterUp": {"frontalisLateral": 1.0, "frontalisMedial": 0.2},
    "eyeBlink": {"orbicularisLateral": 0.15},
    "eyeSquint": {"orbicularisLateral": 0.6, "orbicularisOculi": 0.2},
    "eyeWide": {"frontalisLateral": 0.08},
    "cheekSquint": {"orbicularisOculi": 1.0, "orbicularisLateral": 0.4},
    "noseSneer": {"levatorNasi": 1.0, "procerus": 0.2, "levatorLabii": 0.1},
    "mouthUpperUp": {"levatorLabii": 1.0, "levatorNasi": 0.1},
    "mouthSmile": {"zygomaticus": 1.0, "buccinator": 0.1, "orbicularisOculi": 0.12},
    "mouthFrown": {"depressorAnguli": 1.0, "mentalis": 0.1, "platysma": 0.1},
    "mouthDimple": {"buccinator": 1.0, "risorius": 0.15},
    "mouthStretch": {"risorius": 1.0, "platysma": 0.6, "depressorLabii": 0.1},
    "mouthLowerDown": {"depressorLabii": 1.0, "platysma": 0.1},
    "mouthPress": {"press": 1.0, "mentalis": 0.1, "buccinator": 0.1},
}
"""Of each side's unit: the same side's muscles, and the middle ones."""

UPPER = ("frontalisMedial", "frontalisLateral", "corrugator", "procerus", "orbicularisOculi", "orbicularisLateral")
"""Muscles above the nose; a habit brings along a neighbour above or below, not across."""
