"""The type stubs, the docstrings and the module say the same."""
# SPDX-License-Identifier: Apache-2.0
import ast
import pathlib
import re
import shutil
import subprocess

import pytest

import diesink

FOLDER = pathlib.Path(diesink.__file__).parent
STUBS = ast.parse((FOLDER / "__init__.pyi").read_text())
CLASSES = {node.name: node for node in STUBS.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUBS.body if isinstance(node, ast.FunctionDef)}


def arguments(node):
    """Names of the arguments as the stub states them; those by name only after '*'."""
    args = node.args
    words = [each.arg for each in args.args]
    if args.vararg:
        words.append("*" + args.vararg.arg)
    elif args.kwonlyargs:
        words.append("*")
    return words + [each.arg for each in args.kwonlyargs]


def arguments_of_docstring(function):
    """The same of pybind11's first line: name(self: ..., x: object, *, threads: int = 0) -> ..."""
    inside = re.match(r"\w+\((.*)\) -> ", function.__doc__.splitlines()[0]).group(1)
    depth, words, word = 0, [], ""
    for letter in inside:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            words.append(word)
            word = ""
        else:
            word += letter
    words.append(word)
    names = [each.strip().split(":")[0].split("=")[0] for each in words if each.strip()]
    return ["*outputs" if each == "*args" else each for each in names]


def test_the_same_names():
    public = {name for name in diesink.__all__ if not name.startswith("__")}
    assert public == set(CLASSES) | set(FUNCTIONS)
    assert (FOLDER / "py.typed").exists()


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_functions(name):
    function = getattr(diesink, name)
    assert arguments_of_docstring(function) == arguments(FUNCTIONS[name])
    assert len(function.__doc__.splitlines()) > 2, "no docstring"


@pytest.mark.parametrize("name", sorted(set(CLASSES) - {"Error"}))
def test_classes(name):
    kind = getattr(diesink, name)
    assert kind.__doc__
    stubs = {node.name: node for node in CLASSES[name].body if isinstance(node, ast.FunctionDef)}
    public = {each for each in vars(kind) if not each.startswith("_")}
    assert public == {each for each in stubs if not each.startswith("_")}
    for each, node in stubs.items():
        member = getattr(kind, each)
        if isinstance(member, property):
            assert member.__doc__, each
        elif each != "__len__":
            assert arguments_of_docstring(member) == arguments(node), each


def test_a_type_checker_accepts_them(tmp_path):
    mypy = shutil.which("mypy")
    if mypy is None:
        pytest.skip("mypy is not installed (Debian: mypy)")
    subprocess.run([mypy, "--strict", "--cache-dir", tmp_path, FOLDER / "__init__.pyi"], check=True)
