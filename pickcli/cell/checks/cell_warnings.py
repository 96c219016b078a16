"""Kinds of warnings about a cell, by which a cell file can accept intended values."""

# Every kind of warning about a cell file, with its subject.
CELL_WARNINGS = {
    "slow_device": "a device's lead",
    "useless_device": "a device that no plan could switch",
    "no_device": "a device that a pick needs",
    "weak_or_strong_cup": "what a cup bears, against its size",
    "large_cup": "the size of a cup",
    "cup_not_as_drawn": "the size of a cup, against its shapes",
    "odd_gripper": "what a gripper bears",
    "odd_clearance": "the clearance",
    "no_seal_time": "the time to seal",
    "fast_joint": "limits of a joint",
    "slow_joint": "limits of a joint, against each other",
    "strong_motor": "a motor's force",
    "no_mass": "a link without a mass",
    "heavy_link": "a link's mass, against its shapes",
    "odd_angle": "an angle of a pose",
    "narrow_place": "the size of a place",
    "tilted_pod": "a pod that leans",
    "blocked_place": "an obstacle or another place in a place",
    "no_configuration": "a place, or home, without a configuration",
    "no_such_place": "a configuration of kind bin that is named after no place",
    "astray": "a configuration far from its place",
    "untested_pair": "an allowed pair that is far apart",
    "out_of_reach": "a place that the tool hardly reaches",
    "poor_configuration": "a configuration from which little of its place is reached",
}
