"""Measure the house: its limits, side by side with what it is. `python tools/house.py` prints the table and the rest.

Lines of code are lines that hold a token other than a comment or a docstring. Expression nodes a line are the nodes of
Python's syntax tree that are expressions (names, attributes, calls, operators, subscripts, comprehensions) within the
bodies of functions, without constants, annotations and docstrings, over the lines of code of those bodies.
"""

import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
ROOT = HERE / "src" / "mien"
TESTS = HERE / "tests"

FUNCTION_LINES = 60
FILE_LINES = 300
NODES_A_LINE = 6.0
MODULES_A_FOLDER = 14
ROOM_SHARE = 1 / 8

FREE_FOLDERS = ("cli", "_kernels")
"""Folders that may hold more modules: a file a verb, a file a kernel and its twin."""

DRIVERS = ("pipeline.py", "tracker.py", "driver.py", "personalize.py", "fitting/register_scan.py", "cli/")
"""What reads like the paper's list of steps: ends of paths, and a folder."""

BANNED_NAMES = """
on_scan register_markers mix off performed agree deform sound laid_over EIGHT off_edges carried parts_follow
fine_held within near_points Sheet places attach sureness runner_up slide adapt prepare upright placement calmed
resting_first responses study blocks bias Rest above observe Sighting sight said Tools begin follow Watch lap settle
steadied still effort ease soft resolve portrait portray bent match Residuals rehearsal held_out complexion props
casting
"""
"""Public names that meant nothing to a reader of the field, or two things."""

BANNED_WORDS = frozenset({"spread", "agreed", "rest"})
"""Words that meant several things: in no public name."""


@dataclass(frozen=True)
class Limit:
    """One limit of the house."""

    what: str
    allowed: str
    found: str
    over: tuple[str, ...]
    """What breaks it, a line each, its room first."""


def modules() -> list[Path]:
    """Every module of the package."""
    return sorted(ROOT.rglob("*.py"))


@cache
def source(path: Path) -> str:
    """A module's text."""
    return path.read_text(encoding="utf-8")


@cache
def tree(path: Path) -> ast.Module:
    """A module's syntax tree."""
    return ast.parse(source(path))


def name(path: Path) -> str:
    """A module as it stands below the package: `io/gltf/mesh.py`."""
    return path.relative_to(ROOT).as_posix()


def room(path: Path) -> str:
    """The room that a module lies in: its package with all sub-packages, or its own name."""
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def functions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """All functions of a module, methods and inner ones too."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node


def long_functions() -> Limit:
    """Functions by their lines, decorators aside."""
    found = [
        (node.end_lineno - node.lineno + 1, path, node.name)
        for path in modules()
        for node in functions(path)
        if node.end_lineno is not None
    ]
    over = [f"{name(p)}: {title}: {n} lines" for n, p, title in found if n > FUNCTION_LINES]
    return Limit(f"functions > {FUNCTION_LINES} lines", "0", str(len(over)), tuple(over))


def long_files() -> Limit:
    """Files by their lines."""
    sizes = {path: len(source(path).splitlines()) for path in modules()}
    over = [f"{name(path)}: {n} lines" for path, n in sizes.items() if n > FILE_LINES]
    return Limit(f"files > {FILE_LINES} lines", "0", str(len(over)), tuple(over))


def dense_drivers() -> Limit:
    """Expression nodes a line of code, a mean over each pipeline, driver and verb."""
    means = {path: nodes_a_line(path) for path in modules() if name(path).endswith(DRIVERS[:-1]) or is_verb(path)}
    over = [f"{name(path)}: {mean:.1f}" for path, mean in means.items() if mean > NODES_A_LINE]
    worst = f"{max(means.values()):.1f} at most"
    return Limit("expression nodes a line, pipelines, drivers and cli", f"<= {NODES_A_LINE:g}", worst, tuple(over))


def is_verb(path: Path) -> bool:
    """Whether a module belongs to the command line."""
    return name(path).startswith(DRIVERS[-1])


def nodes_a_line(path: Path) -> float:
    """Expression nodes a line of code within the bodies of a module's functions."""
    nodes, lines = 0, set()
    for node in functions(path):
        for statement in node.body:
            if is_text(statement):
                continue
            expressions = list(_expressions(statement))
            nodes += len(expressions)
            lines |= {e.lineno for e in ast.walk(statement) if isinstance(e, ast.stmt | ast.expr)}
            lines |= {e.end_lineno for e in ast.walk(statement) if isinstance(e, ast.expr)}
    return nodes / max(len(lines), 1)


def is_text(statement: ast.stmt) -> bool:
    """Whether a statement is a string that stands alone."""
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _expressions(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions below a node, without constants, annotations and inner functions (which are counted themselves)."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.FunctionDef):
                continue
            if isinstance(child, ast.expr) and not isinstance(child, ast.Constant):
                yield child
            yield from _expressions(child)


def full_folders() -> Limit:
    """Modules a folder, `__init__` aside."""
    counts: dict[Path, int] = defaultdict(int)
    for path in modules():
        counts[path.parent] += path.name != "__init__.py"
    counted = {folder: n for folder, n in counts.items() if folder.name not in FREE_FOLDERS}
    over = [f"{name(folder) or '.'}: {n} modules" for folder, n in counted.items() if n > MODULES_A_FOLDER]
    return Limit("modules a folder", f"<= {MODULES_A_FOLDER}", f"{max(counted.values())} at most", tuple(over))


def largest_room() -> Limit:
    """Lines a room, as a share of the package's."""
    lines: dict[str, int] = defaultdict(int)
    for path in modules():
        lines[room(path)] += len(source(path).splitlines())
    total = sum(lines.values())
    shares = {key: n / total for key, n in lines.items()}
    over = [f"{key}: {share:.1%}" for key, share in shares.items() if share > ROOM_SHARE]
    largest = max(shares, key=lambda key: shares[key])
    return Limit("largest room", "<= 12.5 %", f"{largest} {shares[largest]:.1%}", tuple(over))


def circles() -> Limit:
    """Modules that import each other, round about; imports within functions count."""
    graph = {path: imports(path) for path in modules()}
    over = [" -> ".join(name(p) for p in circle) for circle in _cycles(graph)]
    return Limit("circles of imports", "0", str(len(over)), tuple(over))


def imports(path: Path) -> set[Path]:
    """Modules of the package that a module imports."""
    found = set()
    for node in ast.walk(tree(path)):
        if not isinstance(node, ast.ImportFrom) or not node.level:
            continue
        base = path.parents[node.level - 1]
        target = base.joinpath(*node.module.split(".")) if node.module else base
        for alias in node.names:
            found |= {_file(target / alias.name) or _file(target)} - {None, path}
    return {p for p in found if p is not None}


def _file(place: Path) -> Path | None:
    """The file of a module or package."""
    return next((p for p in (place.with_suffix(".py"), place / "__init__.py") if p.is_file()), None)


def _cycles(graph: dict[Path, set[Path]]) -> list[list[Path]]:
    """Groups of modules that reach each other."""
    reach = {path: _reached(graph, path) for path in graph}
    groups = {frozenset(p for p in graph if p in reach[q] and q in reach[p]) for q in graph}
    return [sorted(group) for group in groups if len(group) > 1]


def _reached(graph: dict[Path, set[Path]], start: Path) -> set[Path]:
    found, todo = set(), [start]
    while todo:
        new = graph[todo.pop()] - found
        found |= new
        todo += new
    return found


def test_name(path: Path) -> str:
    """The test file that belongs to a module; a kernel's twin is tested with the kernel."""
    parts = [part.strip("_") for part in path.relative_to(ROOT).with_suffix("").parts]
    return f"test_{'_'.join(parts).removesuffix('_twin')}.py"


def untested_modules() -> Limit:
    """Modules without a test file of their name."""
    over = [name(p) for p in modules() if p.name != "__init__.py" and not (TESTS / test_name(p)).is_file()]
    return Limit("modules without a test file of their name", "0", str(len(over)), tuple(over))


def public_names(path: Path) -> Iterator[str]:
    """The module's own name, and its functions, classes, constants and fields that do not begin with `_`."""
    yield path.stem
    for node in tree(path).body:
        yield from _defined(node)
        if isinstance(node, ast.ClassDef):
            for member in node.body:
                yield from _defined(member)


def _defined(node: ast.stmt) -> Iterator[str]:
    """What a statement gives a name."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        yield node.name
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    yield from (target.id for target in targets if isinstance(target, ast.Name))


def banned() -> Limit:
    """Public names that are banned, or hold a banned word."""
    over, names = [], frozenset(BANNED_NAMES.split())
    for path in modules():
        if room(path).startswith("_"):
            continue
        for public in public_names(path):
            hit = public in names or BANNED_WORDS & set(public.lower().split("_"))
            if hit and not public.startswith("_"):
                over.append(f"{name(path)}: {public}")
    return Limit("public names with words of several meanings", "0", str(len(over)), tuple(over))


def double_types() -> Limit:
    """Public classes whose name stands in two modules."""
    places = defaultdict(list)
    for path in modules():
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].append(name(path))
    over = [f"{', '.join(found)}: {title}" for title, found in places.items() if len(found) > 1]
    return Limit("types that exist twice", "0", str(len(over)), tuple(over))


def limits() -> list[Limit]:
    """All limits, as they stand in docs/architecture.md."""
    return [
        long_functions(),
        long_files(),
        dense_drivers(),
        full_folders(),
        largest_room(),
        circles(),
        untested_modules(),
        banned(),
        double_types(),
    ]


def table(found: list[Limit]) -> str:
    """The limits side by side, as Markdown."""
    rows = [f"| {one.what} | {one.allowed} | {one.found} |" for one in found]
    return "\n".join(["| | limit | now |", "|---|---|---|", *rows])


def main() -> None:
    """Print the table, then what breaks each limit."""
    found = limits()
    print(table(found))
    for one in found:
        print(*[f"\n{one.what}:", *(f"  {line}" for line in one.over)] if one.over else [], sep="\n", end="")
    print()
    sys.exit(any(one.over for one in found))


if __name__ == "__main__":
    main()
