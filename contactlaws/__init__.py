"""Contact laws: parameter records, the scalar compiled functions on them, and the reference curves they are held against."""
