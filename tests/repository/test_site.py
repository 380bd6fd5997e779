"""The site: it builds without a warning, is small, and every page shows itself at 1280 and 390 px without complaint."""

import os
import re
import subprocess
import sys

import pytest
from browser import CHROMIUM, browser
from sources import ROOT

import gearcase
from pipelines.cli.command_line import COMMANDS

MOST_BYTES = 30e6

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    pytest.importorskip("sphinx", reason="the docs tools are not installed: pip install -e '.[docs]'")
    built = tmp_path_factory.mktemp("site")
    words = ["--fail-on-warning", "--keep-going", "--quiet", "-d", built / "doctrees", ROOT / "docs", built / "html"]
    environment = {**os.environ, "MPLBACKEND": "agg"}
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *map(str, words)], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return built / "html"


def pages(site):
    return sorted(site.rglob("*.html"))


def test_the_site_is_small(site):
    assert sum(path.stat().st_size for path in site.rglob("*")) < MOST_BYTES


def test_every_public_name_and_every_command_has_its_page(site):
    for name in gearcase.__all__:
        assert f'id="gearcase.{name}"' in (site / "reference" / "python" / f"{name}.html").read_text(encoding="utf-8")
    for name in COMMANDS:
        text = (site / "reference" / "commands" / f"{name}.html").read_text(encoding="utf-8")
        assert f"usage: gearcase {name}" in text


def test_every_example_is_offered_as_a_notebook(site):
    scripts = {path.stem for path in (ROOT / "examples" / "gallery").glob("*.py")}
    assert {path.stem for path in site.rglob("*.ipynb")} == scripts


def test_links_within_the_site_lead_somewhere(site):
    broken = []
    for page in pages(site):
        for target in re.findall(r'href="([^"#:?]+)[^":]*"', page.read_text(encoding="utf-8")):
            if not (page.parent / target).exists():
                broken.append(f"{page.relative_to(site)}: {target}")
    assert not broken


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
@pytest.mark.parametrize("width", [1280, 390])
def test_every_page_shows_itself_without_an_error_or_an_overflow(site, width, tmp_path):
    wrong = []
    with browser(tmp_path) as view:
        for page in pages(site):
            view.show(page, width, 900)
            wide = view.value("document.documentElement.scrollWidth")
            if wide > width or view.complaints():
                wrong.append(f"{page.relative_to(site)}: {wide} px, {view.complaints()}")
    assert not wrong


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here")
def test_the_search_answers_without_a_server(site, tmp_path):
    with browser(tmp_path) as view:
        view.show(site / "search.html", 1280, 900)
        view.value(
            "new Promise(done => { Search.performSearch('backlash'); const look = () => "
            "document.querySelectorAll('#search-results li').length ? done(1) : setTimeout(look, 100); look(); })"
        )
        assert view.value("document.querySelectorAll('#search-results li a').length") > 0
