"""Named configurations ranked by how much of a bin each reaches."""
