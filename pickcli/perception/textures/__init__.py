"""Printed items recognised by what is printed on them: SIFT features with their places on the item.

After KTH (paper 000, III-B). The only package that uses OpenCV, an extra;
what is solved for several pictures together needs none.

- `opencv` imports the library, for one thread, or says how to install it.
- `print_features` are what SIFT finds in a picture.
- A `print_model` is made of 46 renderings of an item alone, and kept in the user's cache.
- `print_matching` says which features of a picture are like which of a model, by all its views or each view:
  `sift_views`.
- A `print_pose` follows from such matches, by PnP.
- A `joint_pose` follows from the matches in several pictures, without depth, and `print_agreement` says which
  pictures show one copy.
"""
