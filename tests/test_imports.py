"""Imports: fem -> mbd -> pipelines -> gearcase, heavy and licensed packages in one module each, light package files."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted(path for package in ("fem", "mbd", "pipelines", "gearcase") for path in (ROOT / package).rglob("*.py"))
ONLY_IN = {  # package: modules or packages that may import it
    "gmsh": {"fem.casing.meshing.gmsh_session"},
    "pyvista": {"pipelines.figures.view"},
    "vtk": {"pipelines.figures.view"},
    "sksparse": {"fem.numerics.linear_solver"},
    "skfem": {"fem.elements"},
    "pydantic": {"pipelines"},
    "rich": {"pipelines"},
    "tomlkit": {"pipelines.scene.new"},
    "meshio": {"fem"},
    "matplotlib": {"pipelines"},
}
MBD_TAKES = {
    "fem.contact.law",
    "fem.numerics.compiled",
    "fem.numerics.root",
    "fem.contact.evaluation.evaluator",
    "fem.contact.evaluation.kernel",
    "fem.contact.teeth",
    "fem.casing.reduced.body",
    "fem.storage.records",
    "fem.storage.stored_array",
    "fem.named_classes",
}
HEAVY = {"numba", "scipy", "h5py", "xarray", "matplotlib", "gmsh", "pyvista", "skfem", "numpy", "pydantic", "pandas"}


def module_name(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path):
    """Full names of what a file imports, inside functions too; names of modules and of things in them."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def within(name, packages):
    return any(name == package or name.startswith(f"{package}.") for package in packages)


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_a_file_imports_only_what_it_may(path):
    name = module_name(path)
    layer = name.partition(".")[0]
    for imported in imports(path):
        top = imported.partition(".")[0]
        if layer == "fem":
            assert top not in ("mbd", "pipelines", "gearcase"), f"{name} imports {imported}"
        if layer == "mbd":
            assert top not in ("pipelines", "gearcase"), f"{name} imports {imported}"
            assert top != "fem" or within(imported, MBD_TAKES), f"{name} imports {imported}"
        if layer == "pipelines":
            assert top != "gearcase", f"{name} imports {imported}"
        assert top not in ONLY_IN or within(name, ONLY_IN[top]), f"{name} imports {imported}"


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_a_file_has_at_most_400_lines(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400


@pytest.mark.parametrize("path", [p for p in FILES if p.name == "__init__.py"], ids=module_name)
def test_package_files_are_light(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    most = 90 if module_name(path) == "gearcase" else 20  # the list of public names
    assert len(path.read_text(encoding="utf-8").splitlines()) <= most
    at_import = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {alias.name for node in at_import for alias in node.names} | {getattr(n, "module", "") for n in at_import}
    assert not {name.partition(".")[0] for name in names} & (HEAVY | {"fem", "mbd", "pipelines"})


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_the_library_does_not_print(path):
    calls = [n for n in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
    assert not [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]


def run_python(code):
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)


def test_mbd_runs_without_the_packages_of_finite_elements_and_scenes():
    blocked = ("gmsh", "pyvista", "vtk", "skfem", "meshio", "sksparse", "pydantic", "pipelines", "matplotlib")
    modules = [module_name(p) for p in FILES if module_name(p).startswith("mbd")]
    code = f"import sys\nfor name in {blocked!r}:\n    sys.modules[name] = None\n"
    code += "".join(f"import {name}\n" for name in modules)
    done = run_python(code)
    assert done.returncode == 0, done.stderr


def test_what_runs_without_the_mesher():
    code = "import sys\nsys.modules['gmsh'] = None\n"
    code += "".join(f"import {module_name(p)}\n" for p in FILES if "view" not in p.name)
    done = run_python(code)
    assert done.returncode == 0, done.stderr


def test_the_parser_imports_nothing_heavy():
    code = "import sys, pipelines.cli\npipelines.cli.parser().format_help()\n"
    done = run_python(code + f"print(sorted(set(sys.modules) & {HEAVY!r}))")
    assert done.stdout.strip() == "[]", done.stderr
