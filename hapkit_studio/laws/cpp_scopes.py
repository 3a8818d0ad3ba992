"""In which block of a function each of its names is declared: the smallest that holds all its uses."""

import ast
from collections.abc import Iterator

Blocks = tuple[tuple[int, int], ...]


def bodies(statement: ast.stmt) -> list[list[ast.stmt]]:
    """Return the blocks inside a statement."""
    match statement:
        case ast.If():
            return [statement.body, statement.orelse]
        case ast.For():
            return [statement.body]
    return []


def owned(tree: ast.FunctionDef) -> dict[int, dict[int, list[str]]]:
    """Return the names to declare by the block's identity and the place of the statement that needs them."""
    arguments = {a.arg for a in tree.args.args}
    common: dict[str, Blocks] = {}
    for name, path in _uses(tree.body, ()):
        if name not in arguments:
            common[name] = _shared(common.get(name, path), path)
    found: dict[int, dict[int, list[str]]] = {}
    for name, path in common.items():
        block, place = path[-1]
        found.setdefault(block, {}).setdefault(place, []).append(name)
    return found


def _shared(one: Blocks, other: Blocks) -> Blocks:
    """Return the way into the innermost block of both, ending at the earlier statement."""
    way: list[tuple[int, int]] = []
    for (block, place), (other_block, other_place) in zip(one, other, strict=False):
        if block != other_block:
            break
        way.append((block, min(place, other_place)))
        if place != other_place:
            break
    return tuple(way)


def _uses(block: list[ast.stmt], path: Blocks) -> Iterator[tuple[str, Blocks]]:
    for place, statement in enumerate(block):
        here = (*path, (id(block), place))
        inner = bodies(statement)
        for name in _names(statement, inner):
            yield name, here
        for body in inner:
            yield from _uses(body, here)


def _names(statement: ast.stmt, inner: list[list[ast.stmt]]) -> Iterator[str]:
    """Return the local names that stand in a statement itself, outside its blocks."""
    skipped = {id(s) for body in inner for s in body}
    waiting: list[ast.AST] = [statement]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Name) and not _is_generated(node.id):
            yield node.id
        children = ast.iter_child_nodes(node)
        if isinstance(node, ast.Call):
            children = iter(node.args)
        if isinstance(node, ast.For):
            children = iter(())
        waiting.extend(c for c in children if id(c) not in skipped)


def _is_generated(name: str) -> bool:
    return name.startswith("_") and name != "_"
