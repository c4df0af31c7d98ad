"""A surface laid out in an image: layout, features, alignment by flow."""
