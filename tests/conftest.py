"""For all tests: what is skipped when the kernels run interpreted, and why; and no example of hypothesis fails for being slow."""

from __future__ import annotations

import hypothesis
import numba
import pytest

# the first example may load a library or compile a kernel, and a machine may be busy
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """NUMBA_DISABLE_JIT=1 runs the same suite interpreted; tests marked `compiled_only` say why they're left out there."""
    if not numba.config.DISABLE_JIT:
        return
    for item in items:
        marker = item.get_closest_marker("compiled_only")
        if marker is not None:
            reason = marker.kwargs.get("reason") or (marker.args[0] if marker.args else None)
            if not reason:
                raise pytest.UsageError(f"{item.nodeid}: compiled_only needs a reason")
            item.add_marker(pytest.mark.skip(reason=f"interpreted: {reason}"))
