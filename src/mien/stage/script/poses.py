"""What faces do together: visemes of speech, the six emotions of Ekman, and small natural groups, as ARKit weights."""


def both(**units: float) -> dict[str, float]:
    """Units of both sides by their name without the side."""
    return {f"{name}{side}": value for name, value in units.items() for side in ("Left", "Right")}


VISEMES: dict[str, dict[str, float]] = {
    "silence": {},
    "aa": {"jawOpen": 0.45, **both(mouthLowerDown=0.25, mouthUpperUp=0.1)},
    "eh": {"jawOpen": 0.28, **both(mouthStretch=0.25, mouthLowerDown=0.2)},
    "ee": {"jawOpen": 0.12, **both(mouthSmile=0.25, mouthStretch=0.3, mouthDimple=0.15)},
    "oh": {"jawOpen": 0.32, "mouthFunnel": 0.45, "mouthPucker": 0.25},
    "oo": {"jawOpen": 0.14, "mouthPucker": 0.7, "mouthFunnel": 0.2},
    "pp": {"mouthRollLower": 0.25, "mouthRollUpper": 0.2, **both(mouthPress=0.45)},
    "ff": {"jawOpen": 0.06, "mouthRollLower": 0.4, **both(mouthUpperUp=0.2)},
    "th": {"jawOpen": 0.14, "tongueOut": 0.25, **both(mouthLowerDown=0.15)},
    "ss": {"jawOpen": 0.05, **both(mouthStretch=0.3, mouthLowerDown=0.2)},
    "ch": {"jawOpen": 0.1, "mouthFunnel": 0.55, "mouthShrugUpper": 0.15},
    "rr": {"jawOpen": 0.12, "mouthPucker": 0.35, "mouthFunnel": 0.2},
    "ll": {"jawOpen": 0.2, **both(mouthLowerDown=0.2)},
    "mm": {"jawOpen": 0.12, "mouthClose": 0.12, **both(mouthPress=0.2)},
}
"""Weights at full articulation."""

EMOTIONS: dict[str, dict[str, float]] = {
    "joy": both(mouthSmile=0.8, cheekSquint=0.6, eyeSquint=0.3, mouthDimple=0.2, mouthUpperUp=0.25),
    "anger": {"mouthShrugLower": 0.25, **both(browDown=0.9, eyeSquint=0.5, mouthPress=0.5, noseSneer=0.35)},
    "disgust": {**both(noseSneer=0.85, mouthUpperUp=0.55, browDown=0.45, mouthFrown=0.35, cheekSquint=0.3)},
    "fear": {"browInnerUp": 0.8, "jawOpen": 0.2, **both(eyeWide=0.8, mouthStretch=0.6, browDown=0.25, browOuterUp=0.2)},
    "surprise": {"browInnerUp": 0.9, "jawOpen": 0.5, **both(browOuterUp=0.85, eyeWide=0.7)},
    "sadness": {"browInnerUp": 0.75, "mouthShrugLower": 0.45, **both(mouthFrown=0.7, eyeSquint=0.25, mouthPress=0.15)},
    "smirk": {"mouthSmileLeft": 0.75, "mouthDimpleLeft": 0.4, "cheekSquintLeft": 0.3, "mouthLeft": 0.15},
    "doubt": {"browOuterUpRight": 0.85, "browDownLeft": 0.6, "mouthPressRight": 0.4, "mouthRight": 0.25},
    "snarl": {"noseSneerRight": 0.9, "mouthUpperUpRight": 0.7, "cheekSquintRight": 0.5, "eyeSquintRight": 0.4},
    "wink": {"eyeBlinkLeft": 1.0, "cheekSquintLeft": 0.6, "mouthSmileLeft": 0.4},
}
"""Prototypes after Ekman and Friesen's action units, then four lopsided ones."""

GROUPS: dict[str, dict[str, float]] = {
    "brows up": {"browInnerUp": 0.7, **both(browOuterUp=0.6)},
    "brows down": both(browDown=0.7, eyeSquint=0.2),
    "small smile": both(mouthSmile=0.5, mouthDimple=0.2),
    "grin": {"jawOpen": 0.15, **both(mouthSmile=0.7, cheekSquint=0.5, mouthUpperUp=0.3)},
    "pressed lips": {"mouthRollLower": 0.2, **both(mouthPress=0.6)},
    "pout": {"mouthPucker": 0.6, "mouthShrugLower": 0.4},
    "shrug": {"mouthShrugLower": 0.6, "mouthShrugUpper": 0.4, **both(mouthFrown=0.4)},
    "puff": {"cheekPuff": 0.6, **both(mouthPress=0.3)},
    "gape": {"jawOpen": 0.7},
    "jaw aside": {"jawLeft": 0.6, "jawOpen": 0.15},
    "mouth aside": {"mouthRight": 0.6},
    "jaw out": {"jawForward": 0.7},
    "sneer": both(noseSneer=0.6, mouthUpperUp=0.3),
    "squint": both(eyeSquint=0.8, cheekSquint=0.4),
    "stretch": both(mouthStretch=0.7, mouthLowerDown=0.3),
    "teeth": both(mouthUpperUp=0.6, mouthLowerDown=0.6),
    "rolled lips": {"mouthRollLower": 0.7, "mouthRollUpper": 0.6},
}
"""Units that people move together."""

UNITS_IN_TURN = (
    "browInnerUp", "browDownLeft", "browOuterUpRight", "eyeWideLeft", "eyeSquintRight", "cheekSquintLeft",
    "noseSneerRight", "cheekPuff", "mouthSmileLeft", "mouthSmileRight", "mouthFrownLeft", "mouthDimpleRight",
    "mouthUpperUpLeft", "mouthLowerDownRight", "mouthStretchRight", "mouthPressLeft", "mouthPucker", "mouthFunnel",
    "mouthRollLower", "mouthRollUpper", "mouthShrugUpper", "mouthLeft", "jawOpen", "jawLeft", "jawForward",
)  # fmt: skip
"""What the scripted session asks for, one by one."""
