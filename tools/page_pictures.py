"""Pictures of the page for the docs; needs Chromium and Playwright.

python tools/page_pictures.py docs/pictures [DEMO]: with `demo`, after `mien demo rgbd` and `mien demo scans`,
those of a film and of worst regions too.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from playwright.sync_api import sync_playwright

from mien.blendshapes.captures import capture_of_mesh
from mien.blendshapes.map_file import write_map
from mien.clip import Markers
from mien.faces import load_face
from mien.io.gltf import read_performance, write_performance
from mien.io.markers import write_c3d
from mien.io.meshes import write_mesh
from mien.rig import Performance
from mien.stage import make_performer, make_skin, scan, scripted
from mien.transforms import Transform, rotation_from_vector
from mien.viewer.open_files import gather
from mien.viewer.studio import Studio

RATE, SECONDS, FRAME = 30.0, 12.0, 238
"""Of the staged take; the frame that is shown."""

FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
PATIENCE_MS = 180_000
"""With a software GPU on a busy machine."""

WINDOW = {"width": 1180, "height": 720}

PLAYED = """studio.stage.frame('right'); studio.edits.key('jawOpen', 7.0, 0.3); studio.edits.key('jawOpen', 7.6, -0.2);
studio.edits.mark(9.2, 9.6); studio.choose(studio.current.face.names.indexOf('jawOpen'));"""
CLICKS = ((243, 408), (679, 388))
"""Places of the window, by turns on the left scan and on the right."""

SEATED = "studio.stage.frame('right'); studio.markers.take(12)"
MARKED = "studio.map.open.press(true); studio.map.said.landmarks[61] = [288, 353]; studio.map.show()"
READY = "window.studio && Promise.all([studio.markers?.ready, studio.map?.ready]).then(() => true)"

OVER = """studio.over.button.press(true); studio.over.strength.value = 0.6;
studio.over.strength.dispatchEvent(new Event('input'));"""
SPOKEN = 120
"""Frame of the demo's film that is shown."""
WORST = "document.querySelector('#worst button')?.click()"

SPOTS = [(x, y, 110 - 0.007 * x * x) for y in range(-80, 81, 20) for x in range(-60, 61, 20)]
"""Before the face, mm: a marker is on the skin nearest to each."""

BESIDE = """document.querySelector('#surface').value = '2';
document.querySelector('#surface').dispatchEvent(new Event('change')); studio.stage.frame('left');"""


def staged(folder: Path) -> Path:
    """A performance that nods and speaks."""
    weights = scripted(rate=RATE, seconds=SECONDS).weights
    t = np.arange(len(weights)) / RATE
    turn = rotation_from_vector(np.stack([0.06 * np.sin(t), 0.18 * np.sin(0.9 * t), 0 * t], axis=1))
    place = np.stack([5 * np.sin(t), 1500 + 0 * t, 3 * t], axis=1)
    tracked = np.ones(len(t), dtype=bool)
    performance = Performance(load_face().rig, weights, Transform(turn, place), RATE, tracked)
    write_performance(folder / "perf.glb", performance)
    softer = Performance(load_face().rig, weights * 0.6, Transform(turn, place), RATE, tracked)
    write_performance(folder / "softer.glb", softer)
    return folder / "perf.glb"


def scanned(folder: Path) -> list[Path]:
    """Two staged scans of one person."""
    skin, rig = make_skin(make_performer(1)), load_face().rig
    paths = []
    for number, (name, shape) in enumerate((("calm", "jawOpen"), ("smile", "mouthSmileLeft"))):
        weights = np.zeros(len(rig.names))
        weights[rig.index(shape)] = 0.8 * number
        path = folder / f"{name}.ply"
        write_mesh(path, scan(skin, weights, seed=number, name=name).scan.mesh)
        paths.append(path)
    return paths


def marked(folder: Path, performance: Performance) -> Path:
    """A take of markers spread over the face's skin, 7 mm above it."""
    rest = performance.rig.neutral.vertices
    skin = load_face().parts["skin"]
    face = skin[load_face().regions["face"][skin] > 0.5]
    chosen = face[[np.argmin(np.linalg.norm(rest[face] - spot, axis=1)) for spot in SPOTS]]
    places = np.stack([performance.rig.vertices(weights)[chosen] for weights in performance.weights])
    places += 7 * places / np.linalg.norm(places, axis=2, keepdims=True)
    world = np.stack([performance.T_world_face[t].apply(at) for t, at in enumerate(places)])
    write_c3d(folder / "take.c3d", Markers(world, tuple(f"M{m}" for m in range(len(chosen))), RATE))
    return folder / "take.c3d"


def mapped(folder: Path) -> Path:
    """The map of a staged scan."""
    skin = make_skin(make_performer(1))
    weights = np.zeros(len(load_face().rig.names))
    weights[load_face().rig.index("mouthSmileLeft")] = 0.8
    write_map(folder / "smile.exr", capture_of_mesh(scan(skin, weights, seed=1, name="smile").scan, 0.5).map)
    return folder / "smile.exr"


def shoot(
    chromium,
    files: list[Path],
    script: str,
    picture: Path,
    clicks: tuple[tuple[int, int], ...] = (),
    frame: int = FRAME,
) -> None:
    """Open files in the page, run a script there, click, and take the picture."""
    shown, films = gather(files)
    server = Studio(shown, films).open("127.0.0.1")
    page = chromium.new_page(viewport=WINDOW)
    page.set_default_timeout(PATIENCE_MS)
    page.goto(server.address)
    page.wait_for_function(READY)
    page.evaluate(f"{script}; if (studio.clock.duration) studio.clock.seek({frame})")
    for x, y in clicks:
        page.mouse.click(x, y)
    page.wait_for_timeout(500)
    page.screenshot(path=str(picture))
    page.close()
    server.shutdown()
    server.server_close()


def main(folder: Path, demo: Path | None = None) -> None:
    """Write studio.png, and studio_compare, _scans, _markers and _map; from the demos' folders _film and _regions."""
    with TemporaryDirectory() as place, sync_playwright() as driver:
        work = Path(place)
        perf, scans = staged(work), scanned(work)
        chromium = driver.chromium.launch(executable_path="/usr/bin/chromium", args=list(FLAGS))
        shoot(chromium, [perf], PLAYED, folder / "studio.png")
        shoot(chromium, [perf, work / "softer.glb"], BESIDE, folder / "studio_compare.png")
        shoot(chromium, scans, "", folder / "studio_scans.png", CLICKS)
        take = marked(work, read_performance(perf))
        shoot(chromium, [perf, take], SEATED, folder / "studio_markers.png")
        shoot(chromium, [mapped(work)], MARKED, folder / "studio_map.png")
        if demo is not None:
            film = [demo / "rgbd/perf.glb", demo / "rgbd/take"]
            shoot(chromium, film, OVER, folder / "studio_film.png", frame=SPOKEN)
            registered = [demo / "scans/rig.register.json", demo / "scans/scans"]
            shoot(chromium, registered, WORST, folder / "studio_regions.png")
        chromium.close()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
