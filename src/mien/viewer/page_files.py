"""The page's own files, as the server sends them and as a folder holds them."""

import base64
import gzip
import shutil
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from ..files import whole
from .studio_scene import Film

PAGE = ("studio.html", "studio.js", "studio.css")
"""What every page of ours is made of; three.js is bundled within."""

LEVEL = 6
"""Of gzip: more costs seconds and saves nothing."""


def static(name: str) -> bytes:
    """One of the page's files."""
    return files("mien.viewer").joinpath("static", name).read_bytes()


def single_page(scene: bytes, opening: str = "") -> str:
    """The page as one HTML text that holds everything; `opening` is a query such as `play`."""
    packed = base64.b64encode(gzip.compress(scene, LEVEL)).decode()
    page = static("studio.html").decode()
    within = {
        '<link rel="stylesheet" href="studio.css">': f"<style>{static('studio.css').decode()}</style>",
        "<!-- scene -->": f'<script>window.MIEN_SCENE = "{packed}"; window.MIEN_OPENING = "{opening}";</script>',
        '<script src="studio.js"></script>': f"<script>{static('studio.js').decode()}</script>",
    }
    for tag, text in within.items():
        page = page.replace(tag, text)
    return page


def export_page(folder: str | Path, scene: bytes, films: Sequence[Film] = ()) -> int:
    """The page as a folder that needs no server and no network: open its `index.html`. Returns its bytes.

    A name that ends in .html becomes one file that holds everything but films.

    Raises:
        BadInput: the folder cannot be made.
    """
    folder = Path(folder)
    if folder.suffix.lower() == ".html":
        with whole(folder) as temporary:
            temporary.write_text(single_page(scene), encoding="utf-8")
        return folder.stat().st_size
    folder.mkdir(parents=True, exist_ok=True)
    packed = base64.b64encode(gzip.compress(scene, LEVEL)).decode()
    page = static("studio.html").decode().replace("<!-- scene -->", '<script src="scene.js"></script>')
    texts = {"index.html": page.encode(), "scene.js": f'window.MIEN_SCENE = "{packed}";\n'.encode()}
    texts |= {name: static(name) for name in (*PAGE[1:], "studio.LICENSE")}
    for name, text in texts.items():
        with whole(folder / name) as temporary:
            temporary.write_bytes(text)
    for i, film in enumerate(films):
        (folder / "media").mkdir(exist_ok=True)
        shutil.copyfile(film.path, folder / "media" / f"{i}{film.path.suffix}")
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
