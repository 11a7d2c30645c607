"""Following a law along a path."""

from __future__ import annotations

import numpy as np
import pytest

from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from contactlaws.path import scan, trace

LAW = Thornton(1.0, 50.0, 1.0)


def test_a_path_in_two_parts_is_the_whole_path():
    path = np.concatenate((np.linspace(0.0, 0.1, 20), np.linspace(0.1, 0.08, 10)))
    whole = scan(LAW, path)
    second = scan(LAW, path[15:], state=tuple(whole.states[14]))
    np.testing.assert_array_equal(second.force, whole.force[15:])
    np.testing.assert_array_equal(second.states, whole.states[15:])
    np.testing.assert_array_equal(trace(LAW, path).force, whole.force)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"overlap": []}, "overlap"),
        ({"overlap": [0.0, np.nan]}, "overlap"),
        ({"overlap": [0.0, 0.1], "time": [1.0, 0.0]}, "time"),
        ({"overlap": [0.0, 0.1], "time": [1.0]}, "time"),
        ({"overlap": [0.0, 0.1], "state": ()}, "state"),
    ],
)
def test_bad_paths_are_refused(arguments: dict, expected: str):
    with pytest.raises(InputError, match=expected):
        scan(LAW, **arguments)


def test_a_record_that_is_no_law():
    with pytest.raises(InputError, match="is no registered law"):
        scan((1.0, 2.0), [0.1])
