"""A colour-and-depth take, whatever file it is from."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..camera import Camera
from ..depth import RGBDFrame
from ..one_line import count, one_line


@dataclass(frozen=True)
class RgbdTake:
    """A take whose frames are read one by one, each time anew that it is walked through."""

    name: str
    """What messages call it."""
    camera: Camera
    """Of colour, to which depth is registered."""
    rate: float
    """Frames a second."""
    count: int
    """Frames that the take should have."""
    has_depth: bool
    frames: Callable[[], Iterator[RGBDFrame]]
    """A new walk through the frames. A frame that cannot be read raises BadInput; those before it are good."""
    guessed_camera: bool = False
    """The camera is an assumption: a video does not say what lens took it."""
    depth_scale: float | None = None
    """Units a metre that the folder's depth images were read with; None where the file itself is sure."""

    notes: tuple[str, ...] = ()
    """What the reader assumed, mended or left out, a line each."""

    def __repr__(self) -> str:
        kind = "colour and depth" if self.has_depth else "colour"
        frames = count(self.count, "frames")
        return one_line(self, self.name, f"{frames} at {self.rate:g} a second", kind, self.camera)

    def __iter__(self) -> Iterator[RGBDFrame]:
        return self.frames()

    def __len__(self) -> int:
        return self.count
