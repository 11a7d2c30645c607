"""Tasks: planned, hashed, run in processes, and kept in a folder of results."""
