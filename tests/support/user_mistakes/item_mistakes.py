"""Mistakes in a file of items."""

from __future__ import annotations

from support.user_mistakes.mistake import Mistake, Replacement

BONES = "box: [0.206, 0.136, 0.033]"
NARROW = 'why_not: "needs pinching: 1.36 kg on a narrow handle between two heads"'
SHIRT = "mass: 0.0575"
SHIRT_DEFORMS = 'x 0.006 m spread out)"\n    deforms: 0.008'


def _items(name: str, told: str, *changes: Replacement, strict: bool = False) -> Mistake:
    """A mistake in a file of items that ``apc check`` finds; with ``--strict`` where it may be meant."""
    return Mistake(name, "check ITEMS" + " --strict" * strict, told, items=changes)


ITEM_MISTAKES = (
    _items(
        "a tilt in degrees",
        "items.barkely_hide_bones.max_tilt: … equal to 1.5708 (pi/2), got 30; angles are in rad, …",
        (BONES, f"{BONES}\n    max_tilt: 30"),
    ),
    _items(
        "a tilt left blank",
        "items.barkely_hide_bones.max_tilt: expected a number, got nothing; give it in rad, or leave …",
        (BONES, f"{BONES}\n    max_tilt:"),
    ),
    _items(
        "box in mm",
        "items.barkely_hide_bones.box[0]: expected … to 2, got 206; lengths are in m, not mm",
        (BONES, "box: [206, 136, 33]"),
    ),
    _items(
        "box in cm",
        "items.barkely_hide_bones.box[0]: expected … to 2, got 20.6; lengths are in m, not mm",
        (BONES, "box: [20.6, 13.6, 3.3]"),
    ),
    _items(
        "box ten times too large",
        "items.barkely_hide_bones.mass: … than foam; are sizes in m and masses in kg?",
        (BONES, "box: [1.206, 1.136, 0.933]"),
        strict=True,
    ),
    _items(
        "box with two numbers",
        "items.barkely_hide_bones.box: expected … in m: at least 3 entries, got 2; correct it",
        (BONES, "box: [0.206, 0.136]"),
    ),
    _items(
        "box with a negative side",
        "items.barkely_hide_bones.box[1]: … m: greater than or equal to 0.0001, got -0.136; correct it",
        (BONES, "box: [0.206, -0.136, 0.033]"),
    ),
    _items(
        "box with a side of 0",
        "items.barkely_hide_bones.box[1]: … in m: greater than or equal to 0.0001, got 0; correct it",
        (BONES, "box: [0.206, 0, 0.033]"),
    ),
    _items(
        "two shapes",
        "items.barkely_hide_bones: expected exactly one of box, cylinder and sphere; keep one",
        (BONES, BONES + "\n    sphere: [0.1]"),
    ),
    _items(
        "no shape",
        "items.barkely_hide_bones: expected exactly one of box, cylinder and sphere; keep one",
        (BONES, ""),
    ),
    _items(
        "mass in g",
        "items.cherokee_easy_tee_shirt.mass: expected … to 20, got 57.5; masses are in kg, not g",
        (SHIRT, "mass: 57.5"),
    ),
    _items(
        "a light mass in g",
        "items.cherokee_easy_tee_shirt.mass: … metal; are sizes in m and masses in kg?",
        (SHIRT, "mass: 8"),
        strict=True,
    ),
    _items(
        "mass in pounds as text",
        'items.cherokee_easy_tee_shirt.mass: expected … "0.12 lb"; write the number alone, in kg',
        (SHIRT, 'mass: "0.12 lb"'),
    ),
    _items(
        "mass 0",
        "items.cherokee_easy_tee_shirt.mass: expected a mass in kg: greater than 0, got 0; correct it",
        (SHIRT, "mass: 0"),
    ),
    _items(
        "mass negative",
        "items.cherokee_easy_tee_shirt.mass: expected … kg: greater than 0, got -0.0575; correct it",
        (SHIRT, "mass: -0.0575"),
    ),
    _items(
        "bonus of 2.5",
        "items.cherokee_easy_tee_shirt.bonus: expected … to 10: a valid integer, got 2.5; correct it",
        (
            f"{SHIRT}\n    bonus: 1",
            f"{SHIRT}\n    bonus: 2.5",
        ),
    ),
    _items(
        "seal in percent",
        "items.barkely_hide_bones.seals.+z: expected … to 1, got 50; shares are of 1, not per cent",
        (
            BONES + '\n    mass: 0.08\n    bonus: 0\n    seal: 0.0\n    seals: {"+z": 0.5',
            BONES + '\n    mass: 0.08\n    bonus: 0\n    seal: 0.0\n    seals: {"+z": 50',
        ),
    ),
    _items(
        "a face that the shape lacks",
        "items.barkely_hide_bones: expected faces of its shape (+x, -x, +y, -y, +z, -z), got mantle",
        (
            'seals: {"+z": 0.5, "-z": 0.5}\n    seal_source: "loose bag under a header',
            'seals: {mantle: 0.5}\n    seal_source: "loose bag under a header',
        ),
    ),
    _items(
        "no reason why nothing seals",
        "items.fitness_gear_3lb_dumbbell: expected … full vacuum, and only there; add or remove it",
        (f"    {NARROW}\n", ""),
    ),
    _items(
        "a name with capitals",
        'items.Cherokee_Tee: expected a name of small letters, digits and _, got "Cherokee_Tee"',
        ("  cherokee_easy_tee_shirt:", "  Cherokee_Tee:"),
    ),
    _items(
        "a name twice",
        "items.barkely_hide_bones: stands twice; keep one",
        ("  cherokee_easy_tee_shirt:", "  barkely_hide_bones:"),
    ),
    _items(
        "year as text",
        'year: expected the year whose rules give the bonus: … got "2016"; write 2016, without quotes',
        ("year: 2016", 'year: "2016"'),
    ),
    _items(
        "year far off",
        "year: expected the year whose rules give the … than or equal to 2015, got 16; correct it",
        ("year: 2016", "year: 16"),
    ),
    _items(
        "a misspelt key",
        "items.cherokee_easy_tee_shirt.mass: expected a mass in kg, got nothing; add it",
        (SHIRT, "masse: 0.0575"),
    ),
    _items(
        "indentation lost",
        "not YAML: did not find expected key; is the line indented as those beside it, or …?",
        ("  cherokee_easy_tee_shirt:\n    box", "  cherokee_easy_tee_shirt:\n  box"),
    ),
    _items(
        "an inset in mm",
        "items.cherokee_easy_tee_shirt.seal_inset: … to 0.5, got 5; lengths are in m, not mm",
        (
            '    seal_inset: 0.005\n    folded: "folded to 0.22',
            '    seal_inset: 5\n    folded: "folded to 0.22',
        ),
    ),
    _items(
        "an area inside out",
        "items.clorox_utility_brush: expected [least, greatest] for x of +z, got [0.045, -0.045]",
        ('"+z": {x: [-0.045, 0.045], y', '"+z": {x: [0.045, -0.045], y'),
    ),
    _items(
        "no source",
        "items.cherokee_easy_tee_shirt.source: … the figures come from, got nothing; add it",
        ('    source: "size: team_pfn; mass: 55 to 60 g on duke\'s scale"\n', ""),
    ),
    _items(
        "an error of the mass in per cent",
        "items.cherokee_easy_tee_shirt.mass_error: … to 1, got 5; shares are of 1, not per cent",
        (SHIRT, SHIRT + "\n    mass_error: 5"),
    ),
    _items(
        "a look in mm inside of its box",
        "items.cherokee_easy_tee_shirt.deforms: … to 0.1, got 8",
        (SHIRT_DEFORMS, SHIRT_DEFORMS.replace("0.008", "8")),
    ),
    _items(
        "a look deeper than its box allows",
        "items.cherokee_easy_tee_shirt: deforms: expected a box, and at most 0.01 m, 0.4 of its thinnest "
        "side; make it less, or leave it out",
        (SHIRT_DEFORMS, SHIRT_DEFORMS.replace("0.008", "0.02")),
    ),
    _items(
        "a dash in a name",
        'items.tee-shirt: expected a name of small letters, digits and _, got "tee-shirt"; correct it',
        ("  cherokee_easy_tee_shirt:", "  tee-shirt:"),
    ),
    _items(
        "an area in mm",
        "items.clorox_utility_brush: expected x of +z within … m of the middle, got [-45.0, 45.0]; lengths",
        ('"+z": {x: [-0.045, 0.045], y', '"+z": {x: [-45, 45], y'),
    ),
    _items(
        "an area along the normal of its face",
        "items.clorox_utility_brush: expected an area along x and y … got z of +z; correct the axis",
        ('"+z": {x: [-0.045, 0.045], y', '"+z": {z: [-0.02, 0.02], y'),
    ),
    _items(
        "an area beside its face",
        "items.clorox_utility_brush: expected x of +z within … got [0.3, 0.4]; lengths are in m",
        ('"+z": {x: [-0.045, 0.045], y', '"+z": {x: [0.3, 0.4], y'),
    ),
    _items(
        "an inset wider than the item",
        "items.barkely_hide_bones: expected a seal_inset under 0.068 m, half … got 0.2; nothing is left",
        (
            'KTH the card at one end"\n    seal_inset: 0.005',
            'KTH the card at one end"\n    seal_inset: 0.2',
        ),
    ),
)
