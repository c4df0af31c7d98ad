"""What records the stage, with the faults of the real devices."""
