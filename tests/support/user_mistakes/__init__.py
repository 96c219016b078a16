"""Mistakes that users make, as data: what is changed, what is called, what is said."""
