"""Statics of a scene: which contacts bear weight, and what falls, rolls or slumps when an item is removed.

Contacts: `patches` are the areas in which two solids of the `scene` meet, `solid_contact` the forces that
they can bear, and `contact_graph` has all of them. `balance` solves the statics of single items, which
with hollows have `hollow_contacts`, `supports`
predicts which fall or roll when another is removed, `pushing` which may be pushed aside then and which ride
along, `toppling` how a push turns an item over, `sliding` how one moves it off others, `landing` whether one
tips over as it falls onto another, and `balance_warning` warns of those that cannot be at rest.
`unrecognised` finds what nobody recognised beside an item.
"""
