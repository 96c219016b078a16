"""Safe reading and writing of files, independent of robots.

Start with `bounded_reading` and `file_kind` (access and kinds of files), then `yaml_reader`, `json_reader`,
`xml_reader` and `schema` (values with their positions); `xml_mistakes` collects all mistakes of a file,
`file_warnings` reports implausible values. Then `atomic_write` and `file_lock` (atomic writes, one writer at
a time), `derived_cache`, which stores results derived from files, and `packed_array` (arrays in JSON).
"""
