"""Faces over a network, frame by frame: VMC (Open Sound Control) and Live Link Face, out; Live Link Face, in."""
