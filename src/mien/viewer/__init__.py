"""Pages that move: static files that ask nothing of the network."""
