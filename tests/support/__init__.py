"""What tests of several rooms share: cells, scenes, plans and references made by hand."""
