"""Edge loops of a quad mesh: rings round the neck, the eyes and the mouth."""

import numpy as np


class QuadNet:
    """Which quads lie beside each edge, and which vertices are neighbours."""

    def __init__(self, quads: np.ndarray):
        self.quads = quads
        self.beside: dict[frozenset, set[int]] = {}
        self.neighbours: dict[int, set[int]] = {}
        for i in range(len(quads)):
            for edge in self.edges(i):
                self.beside.setdefault(edge, set()).add(i)
                for a in edge:
                    self.neighbours.setdefault(a, set()).update(edge - {a})

    def edges(self, quad: int) -> list[frozenset]:
        """The sides of one quad."""
        q = self.quads[quad].tolist()
        return [frozenset((a, b)) for a, b in zip(q, q[1:] + q[:1], strict=True) if a != b]

    def ring(self, first: int, second: int) -> np.ndarray:
        """The closed edge loop that starts from `first` to `second` and runs straight on at every crossing."""
        loop = [first, second]
        while len(loop) < 500:
            a, b = loop[-2:]
            here = self.beside[frozenset((a, b))]
            ahead = [c for c in self.neighbours[b] if c != a and not self.beside[frozenset((b, c))] & here]
            if len(self.neighbours[b]) != 4 or len(ahead) != 1:
                break
            if ahead[0] == first:
                return np.array(loop)
            loop.append(ahead[0])
        raise SystemExit(f"no closed edge loop along the edge {first}-{second}: the base mesh has changed")


def arcs(ring: np.ndarray, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A ring (k,) round an eye or the mouth -> its upper and lower arc, both from least to greatest x, ends shared."""
    ring = np.roll(ring, -int(vertices[ring, 0].argmin()))
    end = int(vertices[ring, 0].argmax())
    one, other = ring[: end + 1], np.r_[ring[0], ring[: end - 1 : -1]]
    return (one, other) if vertices[one, 1].mean() > vertices[other, 1].mean() else (other, one)
