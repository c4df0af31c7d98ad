"""How a verb ends: what it wrote, what to do next, and both as JSON."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..files import Written

FACES = (".glb", ".usd", ".usda", ".usdc", ".usdz")
_MOST = 6
"""Files of one folder that are named one by one."""
BLENDER_FPS, BLENDER_FRAMES = 24.0, 250
"""What Blender's scenes begin with, and keep when a glTF file comes in."""


def folded(written: Sequence[Path]) -> list[str]:
    """Files written, in order and once each; many of one folder as that folder."""
    unique = list(dict.fromkeys(written))
    folders = [path.parent for path in unique]
    names = []
    for path in unique:
        many = folders.count(path.parent) > _MOST
        names.append(f"{path.parent}/" if many else str(path))
    return list(dict.fromkeys(names))


def next_steps(verb: str, written: Written) -> list[str]:
    """What to do with what was written, a line each."""
    faces = [path for path in written.paths if path.suffix.lower() in FACES]
    if not faces or verb == "demo":
        return []
    face = faces[0]
    lines = []
    if face.suffix.lower() == ".glb":
        lines.append(f"next: `mien view {face}` shows it, `mien {face}` says what else can be done with it")
    else:
        lines.append(f"next: `mien {face}` says what can be done with it")
    if face in written.clocks:
        lines.append(blender_line(face, *written.clocks[face]))
    return lines


def blender_line(face: Path, rate: float, frames: int) -> str:
    """What to set in Blender, which takes no rate from a file."""
    told = f"Blender keeps {BLENDER_FPS:g} frames a second: set {rate:g} before the import"
    if face.suffix.lower() == ".glb" and frames - 1 > BLENDER_FRAMES:
        told += f", and the timeline's end to {frames - 1}"
    return told


def as_json(verb: str, status: int, written: Sequence[Path], said: str, fault: str) -> str:
    """One object: the verb, the exit status, files, the lines that it would have printed, and what went wrong."""
    lines = [line for line in said.splitlines() if line.strip()]
    told: dict[str, Any] = {"verb": verb, "status": status, "wrote": folded(written), "said": lines}
    if fault:
        told["error"] = fault
    return json.dumps(told, indent=1, ensure_ascii=False)
