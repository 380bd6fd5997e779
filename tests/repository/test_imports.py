"""Imports: fem -> mbd -> pipelines -> gearcase, heavy and licensed packages in one module each, light package files."""

import ast
import subprocess
import sys

from sources import FILES, ROOT, module_name, nodes, text

ONLY_IN = {  # package: modules or packages that may import it
    "gmsh": {"fem.casing.mesh.gmsh_session"},
    "pyvista": {"pipelines.report.figures.renderer"},
    "vtk": {"pipelines.report.figures.renderer"},
    "skfem": {"fem.elements"},
    "pydantic": {"pipelines"},
    "rich": {"pipelines"},
    "tomlkit": {"pipelines.scene.new"},
    "meshio": {"fem"},
    "matplotlib": {"pipelines"},
}
MBD_TAKES = {
    "fem.contact.law",
    "fem.options",
    "fem.numerics.compiled",
    "fem.numerics.inner_functions",
    "fem.numerics.root_finding",
    "fem.contact.evaluation.evaluator",
    "fem.contact.evaluation.kernel",
    "fem.contact.teeth",
    "fem.casing.reduced.reduced_body",
    "fem.storage.records",
    "fem.storage.large_array_file",
    "fem.named_classes",
}
HEAVY = {"numba", "scipy", "h5py", "xarray", "matplotlib", "gmsh", "pyvista", "skfem", "numpy", "pydantic", "pandas"}


def imports(path):
    """Full names of what a file imports, inside functions too; names of modules and of things in them."""
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def within(name, packages):
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def allowed(name, imported):
    layer, top = name.partition(".")[0], imported.partition(".")[0]
    above = {"fem": ("mbd", "pipelines", "gearcase"), "mbd": ("pipelines", "gearcase"), "pipelines": ("gearcase",)}
    if top in above.get(layer, ()) or (layer == "mbd" and top == "fem" and not within(imported, MBD_TAKES)):
        return False
    return top not in ONLY_IN or within(name, ONLY_IN[top])


def test_a_file_imports_only_what_it_may():
    found = [(module_name(path), imported) for path in FILES for imported in imports(path)]
    assert len(found) > 1000
    wrong = [f"{name} imports {imported}" for name, imported in found if not allowed(name, imported)]
    assert not wrong, "\n".join(wrong)


def test_package_files_are_light():
    packages = [path for path in FILES if path.name == "__init__.py"]
    assert len(packages) > 30
    wrong = []
    for path in packages:
        name, lines = module_name(path), len(text(path).splitlines())
        if lines > (105 if name == "gearcase" else 20):  # the list of public names
            wrong.append(f"{name}: {lines} lines")
        at_import = [node for node in nodes(path)[0].body if isinstance(node, ast.Import | ast.ImportFrom)]
        names = {alias.name for node in at_import for alias in node.names}
        names |= {getattr(node, "module", "") for node in at_import}
        heavy = {one.partition(".")[0] for one in names} & (HEAVY | {"fem", "mbd", "pipelines"})
        wrong += [f"{name} imports {one}" for one in sorted(heavy)]
    assert not wrong, "\n".join(wrong)


def test_the_library_does_not_print():
    calls = [(path, node) for path in FILES for node in nodes(path) if isinstance(node, ast.Call)]
    prints = [(path, call) for path, call in calls if isinstance(call.func, ast.Name) and call.func.id == "print"]
    assert not prints, "\n".join(f"{module_name(path)}, line {call.lineno}" for path, call in prints)


def run_python(code):
    return subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)


def test_mbd_runs_without_the_packages_of_finite_elements_and_scenes():
    blocked = ("gmsh", "pyvista", "vtk", "skfem", "meshio", "pydantic", "pipelines", "matplotlib")
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


def test_files_that_define_options_need_neither_numba_nor_scipy():
    code = "import sys; import pipelines.scene.scene; "  # imports every class of options
    done = run_python(code + "print(sorted({'numba', 'scipy'} & set(sys.modules)))")
    assert done.stdout.strip() == "[]", done.stderr


def test_the_parser_imports_nothing_heavy():
    code = "import sys, pipelines.cli.main\npipelines.cli.main.parser().format_help()\n"
    done = run_python(code + f"print(sorted(set(sys.modules) & {HEAVY!r}))")
    assert done.stdout.strip() == "[]", done.stderr


def test_a_check_of_a_machine_needs_no_compiler_and_no_figures():
    code = "import sys; from pipelines.cli.main import main; main(['check', 'minimal'])\n"
    done = run_python(code + "print(sorted({'numba', 'scipy', 'matplotlib', 'pandas', 'xarray'} & set(sys.modules)))")
    assert done.stdout.splitlines()[-1] == "[]", done.stderr


def test_the_file_of_a_command_is_imported_for_that_command_alone():
    code = "import sys\nfrom pipelines.cli.command_line import COMMANDS, parser\nparser(%s).format_help()\n"
    code += "print([name for name in COMMANDS if f'pipelines.cli.{name}' in sys.modules])"
    assert run_python(code % "()").stdout.strip() == "[]"
    assert run_python(code % "['modes', 'minimal']").stdout.strip() == "['modes']"
