"""The one exception that means: the input is at fault, and the message says what to do about it."""


class BadInput(ValueError):
    """Input that cannot be used: one line that says what is wrong, where, and what to do.

    The command line turns it into that line and exit status 2. Any other exception is a fault of ours.
    """
