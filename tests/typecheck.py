"""The checker of array shapes and types in the test run: beartype, with an int allowed where a float is asked for."""

from beartype import BeartypeConf, beartype

checker = beartype(conf=BeartypeConf(is_pep484_tower=True))
