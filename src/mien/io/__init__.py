"""Files in and out: a module a format; `markers`, `meshes` and `rigs` choose by suffix."""
