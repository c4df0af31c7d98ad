"""How nouns and results print: one line that a person can read."""


def one_line(thing: object, *facts: object) -> str:
    """`Kind(fact, fact)`; facts that are None or empty are left out."""
    return f"{type(thing).__name__}({', '.join(str(fact) for fact in facts if fact not in (None, ''))})"


def count(number: int, what: str) -> str:
    """A number with its thousands apart, and what it counts: `1,200 frames`, `1 frame`."""
    one = what[:-3] + "y" if what.endswith("ies") else what[:-4] + "ex" if what.endswith("ices") else what[:-1]
    return f"{number:,} {one if number == 1 else what}"
