"""Which sources a result depends on, and their hash: of what the code does, not of how it is written down.

The modules are found by reading `import` statements from the module that does the task on, also those inside functions. Comments,
docstrings and layout do not enter the hash, nor do modules that touch no number. `__init__.py` of a package counts where the package
itself is imported, not where one of its modules is: what else it brings along takes no part.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterator
from pathlib import Path

from contactlaws.sources import PACKAGES, ROOT

#: messages, files and versions; and the batches themselves, which only carry results
NO_NUMBERS = (
    "contactlaws.csv_rows",
    "contactlaws.curve_csv",
    "contactlaws.curve_files",
    "contactlaws.errors",
    "contactlaws.files",
    "contactlaws.json_input",
    "contactlaws.sources",
    "contactlaws.unloading_table",
    "contactlaws.version",
    "cases",
)


@functools.cache
def meaning_hash(start: str, root: Path = ROOT) -> str:
    """Sixteen hexadecimal digits of all code that module `start` reaches."""
    digest = hashlib.sha256()
    for module in sorted(modules_behind(start, root)):
        digest.update(f"{module}\0{_module_hash(module, root)}\0".encode())
    return digest.hexdigest()[:16]


def modules_behind(start: str, root: Path = ROOT) -> set[str]:
    """The modules of this project that `start` imports, directly or not, itself included.

    >>> found = modules_behind("cases.batch.work.curves")
    >>> "fem.newton" in found, "calibration.fit" in found, "contactlaws.errors" in found
    (True, False, False)
    """
    found, todo = set[str](), [start]
    while todo:
        module = todo.pop()
        if module not in found:
            found.add(module)
            todo += [name for name in _imports(module, root) if not _without_numbers(name)]
    return found


def _without_numbers(module: str) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in NO_NUMBERS)


def _imports(module: str, root: Path) -> Iterator[str]:
    for node in ast.walk(_tree(module, root)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if _file(alias.name, root) is not None)
        elif isinstance(node, ast.ImportFrom) and node.module is not None and node.module.split(".")[0] in PACKAGES:
            for alias in node.names:
                inner = f"{node.module}.{alias.name}"
                yield inner if _file(inner, root) is not None else node.module


def _file(module: str, root: Path) -> Path | None:
    """The source of a module of this project; None for what is from elsewhere."""
    if module.split(".")[0] not in PACKAGES:
        return None
    place = root.joinpath(*module.split("."))
    return next((file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()), None)


@functools.cache
def _tree(module: str, root: Path) -> ast.Module:
    file = _file(module, root)
    if file is None:
        raise LookupError(f"no source of {module} under {root}")
    return ast.parse(file.read_bytes())


@functools.cache
def _module_hash(module: str, root: Path) -> str:
    return hashlib.sha256("\0".join(_canonical(_tree(module, root))).encode()).hexdigest()


def _canonical(node: object) -> Iterator[str]:
    """A syntax tree as text: the same for the same code under every release of Python (which differ in fields that are empty).

    >>> same = [ast.parse("def f(x):\\n  'Doc.'\\n  return x+1 # why"), ast.parse("def f(x): return (x + 1)")]
    >>> len({tuple(_canonical(tree)) for tree in same})
    1
    """
    if isinstance(node, ast.AST):
        yield type(node).__name__
        for name in node._fields:
            value = getattr(node, name, None)
            if name not in ("ctx", "kind", "type_comment") and value is not None and value != []:
                yield name
                yield from _canonical(value)
        yield ")"
    elif isinstance(node, list):
        for item in node:
            if not (isinstance(item, ast.Expr) and isinstance(item.value, ast.Constant) and isinstance(item.value.value, str)):
                yield from _canonical(item)
    else:
        yield repr(node)
