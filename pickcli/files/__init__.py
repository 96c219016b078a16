"""Safe reading and writing of files, independent of robots.

Start with `bounded_reading` and `file_kind` (access and kinds of files), then `source` (values with their
positions, and all mistakes in them), which `yaml_reader` reads and a `schema` validates; `json_reader`;
`xml_reader` with `xml_mistakes`; `file_warnings` reports implausible values. Then `atomic_write` and
`file_lock` (atomic writes, one writer at a time), `png_file`, `derived_cache`, which stores results beside
what they were made from, and `packed_array` (arrays in JSON).
"""
