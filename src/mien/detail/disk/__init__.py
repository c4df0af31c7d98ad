"""Detail on disk: training clips, maps, synthesised frames."""
