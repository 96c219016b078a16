"""Checksummed HDF5 tables: sealed when written, verified when read, recovered if damaged.

Start with `table_format`, then `table_writer` and `table_reader`; `safe_open` translates errors;
`header_backup` and `integrity_scan` handle damaged files. The package is independent of the tables' meaning.
"""
