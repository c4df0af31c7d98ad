"""A frame of a take as people name it: by its number, or by a time."""

from ..errors import BadInput


def told_frame(told: str, rate: float, option: str) -> int:
    """The frame that `option` names: a frame (120), or a time (2.5s, 0.7) at `rate` frames a second.

    Raises:
        BadInput: neither, or before the take.
    """
    text = told.strip().lower()
    try:
        frame = round(float(text.removesuffix("s")) * rate) if text.endswith("s") or "." in text else int(text)
    except (ValueError, OverflowError):
        raise BadInput(f"{option}: expected a frame (120) or a time (2.5s), got {told!r}") from None
    if frame < 0:
        raise BadInput(f"{option}: expected a frame (120) or a time (2.5s), got {told!r}")
    return frame
