"""Maps carried on: to other markers, to other people, into rigs."""
