"""The site: the pages of this folder, the gallery of examples, and a reference made from the code.

`make docs` builds it into build/site without a network. Warnings are errors.
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent))

import reference_pages  # noqa: E402
from docutils import nodes  # noqa: E402
from docutils.utils.math import MathError  # noqa: E402
from docutils.utils.math.latex2mathml import tex2mathml  # noqa: E402
from sphinx.util import logging  # noqa: E402

from pipelines.engine.code_version import library_versions  # noqa: E402

project = "gearcase"
author = "The gearcase project"
copyright = "The gearcase project, BSD-3-Clause"
release = version = library_versions("gearcase")["gearcase"]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["sg_execution_times.rst"]
nitpicky = False

myst_enable_extensions = ["colon_fence", "dollarmath", "substitution"]
myst_substitutions = {"version": version}
html_math_renderer = "mathml"
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

html_theme = "furo"
html_title = "gearcase"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False

sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "examples" / "gallery"),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "image_scrapers": ("matplotlib",),
    "abort_on_example_error": True,
    "capture_repr": (),  # a page shows what a script prints and plots, not the value of its last line
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_memory": False,
    "min_reported_time": 1000,
    "write_computation_times": False,
}


def headed(app, what, name, found, options, lines):
    """The example at the end of a docstring gets its heading, so that it is not read as a part of what is above."""
    first = next((number for number, line in enumerate(lines) if line.startswith(">>>")), None)
    if first is not None:
        lines[first:first] = ["Examples", "--------"]


def mathml(self, node):
    """A formula as MathML, which browsers draw without a script; one that cannot be converted is a warning."""
    block = isinstance(node, nodes.math_block)
    try:
        formula = tex2mathml(node.astext(), as_block=block)
        formula = re.sub(r"<mi>(sin|cos|tan|ln)</mi>", r'<mo lspace="0.17em" rspace="0.17em">\1</mo>', formula)
    except MathError as problem:
        logging.getLogger(__name__).warning("formula %r: %s", node.astext(), problem, location=node)
        formula = ""
    self.body.append(f'<div class="math">{formula}</div>' if block else formula)
    raise nodes.SkipNode


def shortened(app, env):
    """The side bar of the reference of scene keys lists each table of the top level once, not its subtables."""
    entries, seen = next(env.tocs["scene-keys"].findall(nodes.bullet_list)).children[0].children[1], set()
    for entry in list(entries):
        name = entry[0].astext().partition(" (")[0]
        if "." in name or name in seen:
            entries.remove(entry)
        del entry[1:]
        link = next(entry.findall(nodes.reference))
        link.children = [nodes.Text(name)]
        seen.add(name)


def setup(app):
    """The reference is written before the pages are read, and docstrings are headed before numpydoc reads them."""
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))
    app.connect("builder-inited", lambda app: reference_pages.write(HERE / "reference"))
    app.connect("autodoc-process-docstring", headed, priority=100)
    app.connect("env-updated", shortened)
