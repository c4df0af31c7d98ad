"""What is wrong with a command line, in one line."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

from cyclopts import CycloptsError
from cyclopts.exceptions import (
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)


def usage_line(error: CycloptsError, words: list[str], verbs: Iterable[str]) -> str:
    """The fault, what was probably meant, and which help tells more."""
    verb = [words[0]] if words and words[0] in verbs else []
    name = verb[0] if verb else "mien"
    told = fault(error, name, list(verbs))
    help_ = " ".join(["mien", *verb, "--help"])
    return f"{told}; see `{help_}`"


def fault(error: CycloptsError, verb: str, verbs: list[str]) -> str:
    """The fault by its kind; the parser's own words, on one line, for kinds that are not known here."""
    match error:
        case UnknownCommandError(unused_tokens=[word, *_]):
            known = "file" if Path(word).suffix or "/" in word else "verb"
            return f"{word}: no such {known}{meant(word, verbs)}"
        case UnknownOptionError():
            given = error.token.keyword or error.token.value
            option, *_ = given.split("=")
            names = []
            for argument in error.argument_collection:
                names += argument.names if argument.parse else ()
            return f"{option}: no such option of {verb}{meant(option, names)}"
        case UnusedCliTokensError(unused_tokens=[word, *_]):
            return f"{word}: one word too many for {verb}"
        case MissingArgumentError(keyword=str(option)):
            return f"{option}: its value is missing"
        case MissingArgumentError() if error.argument is not None:
            option = error.argument.names[0]
            field = error.argument.field_info
            word = option.lstrip("-").upper()
            shown = option if field.kind is field.KEYWORD_ONLY else word
            return f"{verb}: {shown} is missing"
        case _:
            told = one_line(str(error)).rstrip(".")
            return f"{told[:1].lower()}{told[1:]}"


def meant(word: str, known: list[str]) -> str:
    """A question for the nearest known word, where one is near."""
    near = get_close_matches(word, known, n=1)
    return f"; did you mean {near[0]}?" if near else ""


def one_line(text: str) -> str:
    """Text with its line breaks and runs of spaces closed."""
    return " ".join(text.split())
