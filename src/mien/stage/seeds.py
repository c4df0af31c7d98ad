"""Which performers choices may be made on, and which ones figures are reported on. Never the same."""

TUNING_SEEDS = (1, 2, 3, 31, 32, 33)
"""Look at these as often as you like: defaults were chosen on them, so figures of theirs flatter."""
REPORTING_SEEDS = (501, 502, 503)
"""Figures in the docs are of these. Nothing may be chosen by looking at them."""
MANY_REPORTING_SEEDS = tuple(range(501, 521))
"""The same and more, where a figure needs many takes."""
