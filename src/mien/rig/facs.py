"""The 23 merged expressions of Li et al. 2013."""

FACS23: dict[str, tuple[str, ...]] = {
    "eyeBlinkLeft": ("eyeBlinkLeft",),
    "eyeBlinkRight": ("eyeBlinkRight",),
    "eyeWide": ("eyeWideLeft", "eyeWideRight"),
    "eyeSquint": ("eyeSquintLeft", "eyeSquintRight", "cheekSquintLeft", "cheekSquintRight"),
    "browDown": ("browDownLeft", "browDownRight"),
    "browInnerUp": ("browInnerUp",),
    "browOuterUp": ("browOuterUpLeft", "browOuterUpRight"),
    "noseSneer": ("noseSneerLeft", "noseSneerRight"),
    "cheekPuff": ("cheekPuff",),
    "jawOpen": ("jawOpen",),
    "jawLeft": ("jawLeft",),
    "jawRight": ("jawRight",),
    "mouthClose": ("mouthClose",),
    "mouthFunnel": ("mouthFunnel",),
    "mouthPucker": ("mouthPucker",),
    "mouthLeft": ("mouthLeft",),
    "mouthRight": ("mouthRight",),
    "mouthSmileLeft": ("mouthSmileLeft",),
    "mouthSmileRight": ("mouthSmileRight",),
    "mouthFrown": ("mouthFrownLeft", "mouthFrownRight"),
    "mouthStretch": ("mouthStretchLeft", "mouthStretchRight"),
    "mouthUpperUp": ("mouthUpperUpLeft", "mouthUpperUpRight"),
    "mouthLowerDown": ("mouthLowerDownLeft", "mouthLowerDownRight"),
}
"""The 23 FACS-inspired expressions of Li et al. 2013, who do not list theirs: ARKit's, both sides in one but for
blinks, smiles and what moves the mouth aside. Left out: gaze, tongue, lips rolled, pressed or shrugged, dimples, jaw
forward."""
