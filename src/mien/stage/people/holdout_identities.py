"""Identity targets that the bundled face's identity space has never seen. For the synthetic stage alone."""

from importlib.resources import files

import numpy as np
from jaxtyping import Float


def load_holdout_identities() -> tuple[tuple[str, ...], Float[np.ndarray, "k n 3"]]:
    """Names and displacements (k, n, 3) in millimetres, on the bundled face's vertices, at the targets' full strength.

    A fixed random third of MakeHuman's local identity targets was kept out of `BundledFace.identity`, so that a
    performer made of these lies outside its span. No solver may read them.
    """
    with (files("mien.faces") / "assets" / "performer.npz").open("rb") as file, np.load(file) as data:
        return tuple(data["names"].tolist()), data["displacements"] * float(data["step"])
