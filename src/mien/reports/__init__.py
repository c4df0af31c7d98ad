"""What each system shows of its results: one page a system."""
