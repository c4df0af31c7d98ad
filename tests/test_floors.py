"""The house: imports go down only, never sideways between packages on one floor."""

import ast
from pathlib import Path

import mien

ROOT = Path(mien.__file__).parent

FLOORS = [
    {"_kernels", "errors", "extras", "files", "one_line", "progress", "step_cache"},
    {"transforms", "mesh", "camera", "text"},
    {"clip", "depth", "solve", "flow"},
    {"register", "rig", "rgbd", "units"},
    {"io", "pictures"},
    {"faces", "stream"},
    {"landmarks", "image_space", "takes"},
    {"fitting"},
    {"markers", "scans", "tracking", "blendshapes", "detail", "light", "stage"},
    {"reports", "viewer"},
    {"experiments"},
    {"cli"},
]
OF_NO_ROOM = {"__init__", "__main__"}
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}


def room(path: Path) -> str:
    """The room that a file lies in: its package, or its own name."""
    first = path.relative_to(ROOT).parts[0]
    return first.removesuffix(".py")


def imported_rooms(path: Path) -> set[str]:
    """Rooms of mien that the file imports, wherever in the file the import stands."""
    depth = len(path.relative_to(ROOT).parts)
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            above = path.relative_to(ROOT).parts[: depth - node.level]
            parts = [*above, *(node.module.split(".") if node.module else [])]
            found |= {parts[0]} if parts else {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "mien":
            found.add([*node.module.split("."), node.names[0].name][1])
        elif isinstance(node, ast.Import):
            found |= {a.name.split(".")[1] for a in node.names if a.name.startswith("mien.")}
    return {name for name in found if not name.startswith("__")}


def test_every_room_stands_on_a_floor():
    rooms = {room(p) for p in ROOT.rglob("*.py")} - OF_NO_ROOM
    assert rooms <= set(FLOOR), f"place these on a floor: {rooms - set(FLOOR)}"


def test_imports_go_down():
    wrong = []
    for path in sorted(ROOT.rglob("*.py")):
        here = room(path)
        if here in OF_NO_ROOM:
            continue
        for there in imported_rooms(path) - {here}:
            if FLOOR[there] >= FLOOR[here] and not (FLOOR[here] == FLOOR[there] == 0):
                wrong.append(f"{path.relative_to(ROOT)} (floor {FLOOR[here]}) imports {there} (floor {FLOOR[there]})")
    assert not wrong, "\n".join(wrong)
