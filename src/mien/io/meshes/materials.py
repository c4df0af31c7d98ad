"""Material libraries (MTL) of OBJ files, and pictures that files name in whatever spelling."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ...text.decode_text import decode_text

_PICTURE_KEYS = ("map_kd", "map_ka", "map_basecolor", "map_albedo")
"""What names the colour picture, the best first: exporters that light themselves write `map_Ka` alone."""


def pictures_of(mesh: Path, libraries: Iterable[str]) -> dict[str, Path]:
    """The picture of every material that has one, by the libraries that a mesh file names.

    A line may name several libraries. Where none of those is there, the library of the mesh's own name is taken.
    """
    found: dict[str, Path] = {}
    there = [file for named in libraries for file in _libraries(mesh.parent, named)]
    own = mesh.with_suffix(".mtl")
    for library in there or ([own] if own.is_file() else []):
        found |= _pictures_in(library)
    return found


def file_beside(folder: Path, name: str) -> Path | None:
    """The file that another file in `folder` calls `name`, None where there is none.

    Quotes, backslashes, capitals and folders of the machine that wrote the name are passed over.
    """
    plain = name.strip().strip("\"'").replace("\\", "/")
    if not plain:
        return None
    for path in (folder / plain, folder / plain.rpartition("/")[2]):
        if path.is_file():
            return path
        if path.parent.is_dir():
            alike = (file for file in sorted(path.parent.iterdir()) if file.name.lower() == path.name.lower())
            if (file := next(alike, None)) is not None:
                return file
    return None


def _libraries(folder: Path, named: str) -> list[Path]:
    """The one library whose name a line holds, or its several."""
    whole = file_beside(folder, named)
    several = [whole] if whole else [file_beside(folder, word) for word in named.split()]
    return [file for file in several if file is not None]


def _pictures_in(library: Path) -> dict[str, Path]:
    """The best of each material's pictures that is there."""
    found: dict[str, tuple[int, Path]] = {}
    for material, key, value in _lines(library):
        rank = _PICTURE_KEYS.index(key)
        named = (file_beside(library.parent, name) for name in (value, value.split()[-1]))
        picture = next((file for file in named if file is not None), None)
        if picture is not None and (material not in found or rank < found[material][0]):
            found[material] = rank, picture
    return {material: picture for material, (_, picture) in found.items()}


def _lines(library: Path) -> Iterator[tuple[str, str, str]]:
    """(material, key in lower case, what follows) of every line that names a colour picture."""
    material = ""
    for line in decode_text(library).splitlines():
        key, *rest = re.split(r"\s+", line.strip(), maxsplit=1)
        key, value = key.lower(), "".join(rest).strip()
        if key == "newmtl":
            material = value
        elif key in _PICTURE_KEYS and value:
            yield material, key, value
