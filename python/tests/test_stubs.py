"""The stubs name all that the Rust side has."""

import ast
from pathlib import Path

from catena import _catena


def test_the_stubs_have_all_names_of_the_rust_side():
    tree = ast.parse((Path(_catena.__file__).parent / "_catena.pyi").read_text())
    stubs = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    for name in (name for name in dir(_catena) if not name.startswith("_")):
        assert name in stubs, name
        if not isinstance(stubs[name], ast.ClassDef):
            continue
        known = {getattr(part, "name", None) or getattr(getattr(part, "target", None), "id", None) for part in stubs[name].body}
        own = {member for member in vars(getattr(_catena, name)) if not member.startswith("_")}
        assert own == {member for member in known if member and not member.startswith("_")}, name
