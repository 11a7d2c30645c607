"""The report of a folder of results: page, tables, pictures."""
