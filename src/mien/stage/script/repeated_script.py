"""A repeated script: a calm face, then the same few expressions in several rounds, so that learning can be seen."""

import numpy as np

from ...errors import BadInput
from .poses import EMOTIONS, GROUPS
from .script import Script, _blank, _finish, _in_turn

REPEATED = ("joy", "surprise", "pout", "disgust", "snarl")
"""What is asked for in each round: names in `poses.EMOTIONS` or `poses.GROUPS`."""


def repeated_script(
    rate: float = 30.0,
    seconds: float = 12.0,
    seed: int = 0,
    expressions: tuple[str, ...] = REPEATED,
    rounds: int = 2,
    calm: float = 1.5,
) -> Script:
    """Calm for `calm` seconds, then every expression in turn, `rounds` times over; blinks and glances all along.

    Sizes and timing differ from round to round, as people's do. Cues are named "joy", then "joy again".

    Raises:
        BadInput: rate outside 24..1000, an unknown expression, or under half a second for each.
    """
    known = {**GROUPS, **EMOTIONS}
    unknown = [name for name in expressions if name not in known]
    if unknown:
        raise BadInput(f"expressions: there is no {unknown[0]!r}; known are {', '.join(known)}")
    least = calm + 0.5 * rounds * len(expressions)
    weights, rng = _blank(rate, seconds, least), np.random.default_rng([seed, 5])
    first = round(calm * rate)
    turns = [(name if r == 0 else f"{name} again", known[name]) for r in range(rounds) for name in expressions]
    cues = [("calm", 0, first), *_in_turn(weights, turns, first, len(weights), rate, rng)]
    return _finish(weights, rate, rng, cues)
