"""`fe2dem tournament`: the laws against the same curves, with a table, pictures and a page."""
