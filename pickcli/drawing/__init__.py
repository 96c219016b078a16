"""Pictures of what is stored: a roadmap or a database over its cell, as an image or a page to turn about."""
