"""What a task does: a module for each kind, each with one function `make`, all with the same arguments and result.

`make` takes the task, the folder of results, the records of what it is made from, and a progress callback. It returns the files that it
wrote (relative to the folder), numbers for tables and the report, and why it ended early (None: it did not).

What these modules import decides which sources are in a result's key (`cases.batch.sources`): each names all that it computes with.
"""
