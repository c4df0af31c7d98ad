"""Cameras and projector calibrated from a checkerboard under patterns.

The projector is a camera whose picture is known: where it sees the board's corners is read from the patterns that fall
on them, through a homography fitted to each corner's surroundings (Moreno and Taubin 2012).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from ..camera import Camera
from ..errors import BadInput
from ..extras import require
from ..files import existing
from ..progress import SILENT, Progress
from ..transforms import Transform
from .decode_phase import decode_gray
from .disk.light_take import one_size, pictures_of, read_grey
from .light_rig import LightRig, RigView
from .patterns import PatternSet


@dataclass(frozen=True)
class Board:
    """A checkerboard."""

    columns: int
    """Inner corners along its longer side."""
    rows: int
    square_mm: float

    @property
    def points(self) -> Float[np.ndarray, "corners 3"]:
        """Its corners, mm, in the order in which they are found."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        return np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3) * self.square_mm


def read_board(words: str) -> Board:
    """A board from `9x7x75`: inner corners along both sides, mm a square.

    Raises:
        BadInput: other words.
    """
    try:
        columns, rows, square = words.lower().split("x")
        board = Board(int(columns), int(rows), float(square))
    except ValueError:
        board = Board(0, 0, 0.0)
    if min(board.columns, board.rows) < 3 or not 0 < board.square_mm < 10_000:
        raise BadInput(f"board {words!r}: expected inner corners and mm a square, such as 9x7x75")
    return board


@dataclass(frozen=True)
class BoardConfig:
    """How corners are read in the projector's picture."""

    reach_px: int = 40
    """Half the side of the window round a corner in which patterns are read, camera pixels."""
    least: int = 60
    """Read pixels that a window needs."""
    inlier_px: float = 1.5
    """Of the homography, projector pixels."""
    worst_px: float = 3.0
    """A pose with a larger error than this is left out, and named."""


@dataclass(frozen=True)
class BoardView:
    """One pose of the board: its corners in both pictures."""

    name: str
    camera_px: Float[np.ndarray, "corners 2"]
    projector_px: Float[np.ndarray, "corners 2"]
    """NaN where patterns could not be read round the corner."""


@dataclass(frozen=True)
class RigCalibration:
    """A rig and how well it fits."""

    rig: LightRig
    rms_px: dict[str, float]
    """Reprojection error by view, and `stereo` for both with one pose a board."""
    left_out: tuple[str, ...]


def board_view(
    name: str,
    images: Float[np.ndarray, "slots h w"],
    patterns: PatternSet,
    board: Board,
    config: BoardConfig = BoardConfig(),
) -> BoardView:
    """Find the board in the full-on picture and read the patterns at its corners.

    Raises:
        BadInput: no board of that size is seen.
    """
    full = images[patterns.one("full")]
    corners = find_corners(name, full, board)
    pixels = np.stack([decode_gray(images, patterns, axis, smooth=False).pixel for axis in ("x", "y")], -1)
    return BoardView(name, corners, np.stack([corner_in_projector(corner, pixels, config) for corner in corners]))


def calibrate_folder(
    folder: Path,
    patterns: PatternSet,
    board: Board,
    config: BoardConfig = BoardConfig(),
    progress: Progress = SILENT,
) -> tuple[RigCalibration, list[str]]:
    """Calibrate from a folder of poses, each a folder of pictures; and a line for every pose that is no use.

    Raises:
        BadInput: no poses, or fewer than three of use.
    """
    poses = sorted(path for path in existing(folder).iterdir() if path.is_dir())
    if not poses:
        raise BadInput(f"{folder}: no folders of poses, each with the pictures of one board")
    views, notes, size = [], [], (0, 0)
    for number, pose in enumerate(poses):
        progress.update("reading boards", number, len(poses))
        try:
            view, size = _pose(pose, patterns, board, config)
            views.append(view)
        except BadInput as error:
            notes.append(f"left out: {error}")
    progress.update("reading boards", len(poses), len(poses))
    if not views:
        raise BadInput(notes[0])
    return calibrate(views, board, size, (patterns.width, patterns.height), config), notes


def _pose(folder: Path, patterns: PatternSet, board: Board, config: BoardConfig) -> tuple[BoardView, tuple[int, int]]:
    paths = pictures_of(folder)
    if len(paths) != len(patterns):
        raise BadInput(f"{folder}: {len(paths)} pictures, {len(patterns)} patterns")
    images = [read_grey(path) for path in paths]
    one_size(images, paths)
    height, width = images[0].shape
    return board_view(str(folder), np.stack(images), patterns, board, config), (width, height)


def find_corners(name: str, picture: Float[np.ndarray, "h w"], board: Board) -> Float[np.ndarray, "corners 2"]:
    """The board's inner corners, sub-pixel.

    Raises:
        BadInput: none are found.
    """
    cv2 = require("cv2", "light")
    grey = np.clip(255 * picture / max(float(np.quantile(picture, 0.995)), 1e-6), 0, 255).astype(np.uint8)
    flags = cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners = cv2.findChessboardCornersSB(grey, (board.columns, board.rows), flags=flags)
    if not found:
        raise BadInput(
            f"{name}: no checkerboard of {board.columns} x {board.rows} inner corners in the full-on picture"
        )
    return corners.reshape(-1, 2).astype(float)


def corner_in_projector(
    corner: Float[np.ndarray, " 2"], pixels: Float[np.ndarray, "h w 2"], config: BoardConfig
) -> Float[np.ndarray, " 2"]:
    """Where the projector sees a corner: a homography from the camera's pixels round it to the projector's."""
    cv2 = require("cv2", "light")
    x0, y0 = np.maximum(np.round(corner).astype(int) - config.reach_px, 0)
    x1, y1 = np.round(corner).astype(int) + config.reach_px + 1
    window = pixels[y0:y1, x0:x1]
    known = np.isfinite(window).all(-1)
    if known.sum() < config.least:
        return np.full(2, np.nan)
    y, x = np.nonzero(known)
    source = np.stack([x + x0, y + y0], -1).astype(float)
    homography, _ = cv2.findHomography(source - corner, window[known], cv2.RANSAC, config.inlier_px)
    if homography is None:
        return np.full(2, np.nan)
    return homography[:2, 2] / homography[2, 2]


def calibrate(
    views: list[BoardView],
    board: Board,
    camera_size: tuple[int, int],
    projector_size: tuple[int, int],
    config: BoardConfig = BoardConfig(),
) -> RigCalibration:
    """Both lenses, then where the projector stands, all poses together.

    Raises:
        BadInput: fewer than three poses can be used.
    """
    left_out = []
    while True:
        if len(views) < 3:
            raise BadInput(
                f"calibration: {len(views)} poses can be used, 3 are needed; left out: {', '.join(left_out) or 'none'}"
            )
        rig, errors, worst = _fit(views, board, camera_size, projector_size)
        if max(worst) <= config.worst_px or len(views) == 3:
            return RigCalibration(rig, errors, tuple(left_out))
        bad = int(np.argmax(worst))
        left_out.append(views[bad].name)
        views = views[:bad] + views[bad + 1 :]


def _fit(views: list[BoardView], board: Board, camera_size: tuple[int, int], projector_size: tuple[int, int]):
    cv2 = require("cv2", "light")
    points, seen, shown = [], [], []
    for view in views:
        known = np.isfinite(view.projector_px).all(1)
        points.append(board.points[known].astype(np.float32))
        seen.append(view.camera_px[known].astype(np.float32)[:, None])
        shown.append(view.projector_px[known].astype(np.float32)[:, None])
    flags = cv2.CALIB_FIX_K3
    rms_c, K_c, d_c, *_ = cv2.calibrateCamera(points, seen, camera_size, None, None, flags=flags)
    rms_p, K_p, d_p, *_ = cv2.calibrateCamera(points, shown, projector_size, None, None, flags=flags)
    together = cv2.stereoCalibrateExtended(
        points,
        seen,
        shown,
        K_c,
        d_c,
        K_p,
        d_p,
        camera_size,
        np.eye(3),
        np.zeros(3),
        flags=cv2.CALIB_USE_INTRINSIC_GUESS | flags,
    )
    rms, K_c, d_c, K_p, d_p, R, t = together[:7]
    worst = np.asarray(together[-1]).max(axis=1)
    camera = RigView("camera", _camera(K_c, camera_size), Transform.identity(), _lens(d_c), float(rms_c))
    pose = Transform(np.asarray(R, float), np.asarray(t, float).ravel())
    projector = RigView("projector", _camera(K_p, projector_size), pose, _lens(d_p), float(rms_p))
    errors = {"camera": float(rms_c), "projector": float(rms_p), "stereo": float(rms)}
    return LightRig((camera,), projector), errors, worst


def _camera(K: np.ndarray, size: tuple[int, int]) -> Camera:
    return Camera(float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]), size[0], size[1])


def _lens(distortion: np.ndarray) -> tuple[float, ...]:
    return tuple(float(k) for k in np.asarray(distortion).ravel()[:5])
