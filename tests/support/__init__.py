"""What tests of several packages share: cells, scenes, plans and references made by hand."""
