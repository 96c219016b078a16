"""Items in pictures of one place: which of the listed ones is where.

Read in this order:

- What comes in: `rgbd_picture`, depth and colour of one look; `place_view`, what it shows of one place, and
  `room_sight`, how much of it.
- What is known of items: the `listed_item`, its `product_model` with its `colour_model`; `symmetry` says
  which poses look alike.
- The search: `routing` chooses the way of each item; `print_search` recognises what is printed on items,
  `pose_starts` puts items where they could be, `place_pictures` compare hypotheses with what was seen, and
  `item_search` decides all items of a place together.
- What nobody has seen: `line_of_sight` says how far rays are clear, `unknown_voxels` makes boxes of the rest.
- What comes out: `item_observation`, with the `confidence` by which it is refused or not and its
  `pose_bound`, which follows from the `pose_spread`, and by several looks from their `agreement`;
  `item_perception` is from pictures to answers; `perceived_file` with `perceived_schema` keeps them, and
  `perceived_checks` refuses what no look can have said.
"""
