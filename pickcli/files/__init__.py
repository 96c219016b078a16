"""Reading and writing files safely; knows no robot.

Read `bounded_reading` and `file_kind` (what is opened at all), then `yaml_reader`, `xml_reader` and
`schema` (values with their places), with `xml_mistakes`, which tells many at once, then `atomic_write` and
`file_lock` (whole or not at all, one writer at a time).
"""
