"""Checksummed HDF5 tables: sealed when written, verified when read, recovered where they are damaged.

Read `table_format` first, then `table_writer` and `table_reader`; `safe_open` translates errors,
`header_backup` and `integrity_scan` are for files that are damaged. Nothing here knows what the tables are
about.
"""
