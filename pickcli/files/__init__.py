"""Reading and writing files safely; knows no robot.

Read `bounded_reading` and `file_kind` (what is opened at all), then `yaml_reader`, `json_reader`,
`xml_reader` and `schema` (values with their places); `xml_mistakes` tells many mistakes at once,
`file_warnings` what is probably one. Then `atomic_write` and `file_lock` (whole or not at all, one writer
at a time), `derived_cache`, which keeps what is derived from files, and `packed_array` (arrays in JSON).
"""
