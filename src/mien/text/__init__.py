"""Text as programs write it: encodings, numbers, time codes."""
