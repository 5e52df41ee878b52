"""The choice of the default run: it names tests that exist, and what is named on the command line is taken."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from tiers import COLLECTED, DEFAULT, ONLY_ALL, files_named, of_default

TESTS = Path(__file__).parents[1]


def test_tests_that_are_chosen_exist() -> None:
    for file, names in (*DEFAULT.items(), *ONLY_ALL.items()):
        body = ast.walk(ast.parse(next(TESTS.glob(f"*/{file}")).read_text(encoding="utf-8")))
        known = {node.name for node in body if isinstance(node, ast.FunctionDef)}
        assert {name.split("[")[0] for name in names} <= known, file
    assert not set(DEFAULT) & set(ONLY_ALL)


def test_cases_that_are_chosen_exist(pytestconfig: pytest.Config) -> None:
    """As far as this run has found their files: one of all tests finds all."""
    if any("::" in argument for argument in pytestconfig.args):
        pytest.skip("only some tests of a file were looked for")
    found = pytestconfig.stash[COLLECTED]
    files = {file for file, _ in found}
    chosen = {(file, name) for file, names in (*DEFAULT.items(), *ONLY_ALL.items()) for name in names if "[" in name}
    assert not sorted((file, name) for file, name in chosen - set(found) if file in files)


def test_by_function_and_by_case() -> None:
    assert of_default("test_golden.py", "test_picture_looks_as_it_did[earth/sea]")
    assert not of_default("test_golden.py", "test_picture_looks_as_it_did[earth/orbit]")
    assert of_default("test_numbers_backends.py", "test_no_holes[grid]")
    assert not of_default("test_docs.py", "test_the_diagram_is_that_of_the_program")
    assert of_default("test_docs.py", "test_files_named_in_the_docs_exist")
    assert of_default("test_a_new_file.py", "test_anything")


def test_files_named_are_taken_whole() -> None:
    named = files_named(
        ["tests", "tests/systems/test_sky.py", str(TESTS / "test_golden.py::test_knob_can_be_seen[a::b]")]
    )
    assert named == {Path("tests/systems/test_sky.py").resolve(), TESTS / "test_golden.py"}
