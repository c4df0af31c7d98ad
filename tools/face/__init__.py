"""The steps of `build_face.py`: MakeHuman's open data -> the bundled face."""
