"""A public function of four arguments or more says in `Parameters` what every one of them is, compiled ones too."""

import ast
import re

import pytest
from sources import FILES, ROOT, nodes

MANY = 4
SECTION = re.compile(r"^Parameters\n-+\n(.*?)(?=\n\n|\Z|^\w+\n-+$)", re.MULTILINE | re.DOTALL)
ENTRY = re.compile(r"^(\*{0,2}\w+(?:, \*{0,2}\w+)*) : \S", re.MULTILINE)


def public_functions(node):
    """Functions and methods below a module or a class whose names are all public."""
    for inner in node.body:
        if isinstance(inner, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and not inner.name.startswith("_"):
            if isinstance(inner, ast.ClassDef):
                yield from public_functions(inner)
            elif not any(ast.unparse(decorator).endswith("overload") for decorator in inner.decorator_list):
                yield inner


def arguments(function):
    """Names of the arguments but self or cls, stars as they are written."""
    given = function.args
    names = [one.arg for one in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    stars = [f"{star}{one.arg}" for star, one in (("*", given.vararg), ("**", given.kwarg)) if one]
    return [name for name in names if name not in ("self", "cls")] + stars


def described(function):
    """Names of the entries of the section `Parameters`."""
    section = SECTION.search(ast.get_docstring(function) or "")
    return [] if section is None else [name for names in ENTRY.findall(section[1]) for name in names.split(", ")]


def shortcomings(module):
    """A line per function of many arguments whose section does not name exactly these."""
    functions = [one for one in public_functions(module) if len(arguments(one)) >= MANY]
    return [
        f"line {one.lineno}, {one.name}: Parameters names {described(one)}, the arguments are {arguments(one)}"
        for one in functions
        if sorted(described(one)) != sorted(arguments(one))
    ]


def test_a_function_of_many_arguments_says_what_each_one_is():
    found = [(path.relative_to(ROOT), line) for path in FILES for line in shortcomings(nodes(path)[0])]
    assert not found, "\n".join(f"{path}, {line}" for path, line in found)


WHOLE = '''
@compiled(file)
def force(law, cycle, delta, psi):
    """Force of a law.

    Parameters
    ----------
    law : packed
    cycle, delta, psi : mesh cycles, m, rad,
        none of them : an array

    Raises
    ------
    LawError : none of these is an argument
    """


class Table:
    def look(self, a, b, *c, **d):
        """Numbers.

        Parameters
        ----------
        a, b, *c : N
        **d : m
        """
'''


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("Parameters", "Arguments"),
        ("    law : packed\n", ""),
        ("law : packed", "rule : packed"),
        ("cycle, delta, psi : mesh", "cycle, psi : mesh"),
        ("law : packed", "law, tilt : packed"),
        ("def force(law,", "def force(law, tilt,"),
        ("        **d : m\n", ""),
        ('"""Force of a law.', '"""Force.\n    """, """'),
    ],
)
def test_an_argument_without_a_line_is_found(before, after):
    assert shortcomings(ast.parse(WHOLE)) == []
    changed = WHOLE.replace(before, after, 1)
    assert changed != WHOLE
    assert len(shortcomings(ast.parse(changed))) == 1


@pytest.mark.parametrize(
    "source",
    [
        "def few(a, b, c): ...",
        "def _own(a, b, c, d): ...",
        "class _Own:\n    def f(self, a, b, c, d): ...",
        "class C:\n    def f(self, a, b, c): ...",
        "@overload\ndef f(a, b, c, d): ...",
        "@typing.overload\ndef f(a, b, c, d): ...",
    ],
)
def test_few_arguments_and_private_functions_need_no_section(source):
    assert shortcomings(ast.parse(source)) == []
    asked = "def few(a, b, c, *, d): ...", "class C:\n    @classmethod\n    def f(cls, a, b, c, *d): ..."
    assert all(shortcomings(ast.parse(other)) for other in asked)
