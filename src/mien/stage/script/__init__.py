"""What is performed on the stage."""
