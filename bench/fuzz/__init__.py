"""Broken and hostile files by the thousand: every reader must accept or refuse them, soon."""
