"""Stages: the same input means no work, one changed input exactly the dependent stages."""

import ast
import hashlib
import os
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import psutil
import pytest
from sources import nodes
from test_cache import manifest_of

from fem.processes.executor import Processes
from fem.storage.ledger import count
from pipelines.engine import code_version as code_version_module
from pipelines.engine.cache import Cache
from pipelines.engine.code_version import OWN_PACKAGES, code_version, reachable
from pipelines.engine.run_graph import run_graph
from pipelines.engine.step import Graph, Step, explain
from pipelines.io.errors import CacheWarning, WorkError

CALLS = []


@dataclass(frozen=True)
class Pair:
    width: float
    teeth: int = 20


def make_law(pair):
    CALLS.append("law")
    count("factorisations", 2)
    return {"stiffness": np.array([pair.width, pair.teeth])}


def make_sum(names, laws):
    CALLS.append("sum")
    return {"total": float(sum(law["stiffness"][0] for law in laws)), "names": names}


def make_rounded(digits, total):
    CALLS.append("rounded")
    return {"rounded": round(total["total"], digits)}


def make_text(words, rounded):
    CALLS.append("text")
    return f"{words} {rounded['rounded']}"


def make_slowly(seconds):
    time.sleep(seconds)
    return {"process": os.getpid(), "seconds": seconds}


def make_nothing(message):
    raise ValueError(message)


class OddError(Exception):
    """It cannot be pickled: it takes two arguments and keeps one."""

    def __init__(self, one, other):
        super().__init__(f"{one} {other}")


def fail_oddly(_):
    raise OddError("odd", "words")


def count_children(_, slow=()):
    return {"children": [child.pid for child in psutil.Process().children()], "slow": len(slow)}


def begin(words, quick):
    time.sleep(1.0)  # longer than what is built beside it
    CALLS.append(f"{words} ahead with {quick['seconds']}")
    raise ValueError(words)


def finish(words, **_):
    CALLS.append(words)
    return {"calls": list(CALLS)}


def end_at_once(_):
    os._exit(9)


def graph(widths=(1.0, 2.0), digits=0, words="total"):
    laws = [Step(name=f"law_{n}", kind="law", build=make_law, spec=Pair(w)) for n, w in enumerate(widths, 1)]
    return Graph(
        [
            *laws,
            Step(name="sum", kind="sum", build=make_sum, spec="names", takes={"laws": tuple(law.name for law in laws)}),
            Step(name="rounded", kind="rounded", build=make_rounded, spec=digits, takes={"total": "sum"}),
            Step(name="text", kind="text", build=make_text, spec=words, takes={"rounded": "rounded"}),
        ]
    )


@pytest.fixture
def cache(tmp_path):
    CALLS.clear()
    return Cache(tmp_path)


def built(cache, **changes):
    """Stages built in a run, after checking that `explain` foretold it."""
    foretold = [status.name for status in explain(graph(**changes), cache) if status.action == "build"]
    outcome = run_graph(graph(**changes), cache, ["text"])
    done = [record.name for record in outcome.records if not record.reused]
    assert set(done) <= set(foretold) | {s.name for s in explain(graph(**changes), cache)}
    assert all(name in done for name in foretold)
    return done


def test_the_same_input_means_no_work(cache):
    assert built(cache) == ["law_1", "law_2", "sum", "rounded", "text"]
    CALLS.clear()
    assert built(cache) == []
    assert CALLS == []


def test_a_changed_input_builds_exactly_what_depends_on_it(cache):
    built(cache)
    assert built(cache, widths=(1.0, 5.0)) == ["law_2", "sum", "rounded", "text"]
    assert built(cache, words="sum") == ["text"]
    assert built(cache, widths=(1.0, 2.0)) == []


def test_equal_content_cuts_the_chain_off(cache):
    """2.0 -> 2.2 changes the law and the sum; the sum rounds to the same number, so the text stays."""
    built(cache)
    assert built(cache, widths=(1.0, 2.2)) == ["law_2", "sum", "rounded"]


def test_identical_pairs_share_one_law(cache):
    outcome = run_graph(graph(widths=(3.0, 3.0, 3.0)), cache, ["text"])
    assert CALLS.count("law") == 1
    assert outcome.value("text") == "total 9.0"
    assert outcome.ledger() == {"factorisations": 2}


def test_the_ledger_counts_reused_stages_too(cache):
    run_graph(graph(), cache, ["text"])
    assert run_graph(graph(), cache, ["text"]).ledger() == {"factorisations": 4}


def test_only_what_is_wanted_is_built(cache):
    run_graph(graph(), cache, ["law_2"])
    assert CALLS == ["law"]


def test_explain_names_the_field_and_the_chain(cache):
    built(cache)
    status = {s.name: s for s in explain(graph(widths=(1.0, 5.0)), cache)}
    assert status["law_1"].action == "reuse"
    assert status["law_2"].action == "build"
    assert status["law_2"].reason == "width 2.0 -> 5.0"
    assert (status["sum"].action, status["sum"].reason) == ("follow", "after law_2")
    assert CALLS.count("law") == 2


def test_explain_on_an_empty_cache(cache):
    status = explain(graph(), cache)
    assert [s.action for s in status] == ["build"] * 5
    assert [s.first for s in status] == [True] * 5
    assert status[0].reason == "first run"


@dataclass(frozen=True)
class Scene:
    values: dict[str, float]


def test_explain_compares_with_a_variant_and_not_with_another_scene(cache):
    """4 of 40 values changed is a variant; with 20 it is another scene, whose differences say nothing."""

    def one(changed):
        spec = Scene({f"value_{n}": n + (n < changed) for n in range(40)})
        return Graph([Step(name="law", kind="law", build=make_nothing, spec=spec)])

    made = {"content": "", "seconds": 0.0, "peak_bytes": 0, "ledger": {}}
    cache.store("law", one(0).steps["law"].key({}), lambda folder: None, {**one(0).steps["law"].facts({}), **made})
    (variant,) = explain(one(4), cache)
    assert not variant.first
    assert variant.reason.count("->") == 4
    (other,) = explain(one(20), cache)
    assert other.first
    assert other.reason == "first run"


def test_a_damaged_result_is_built_again_with_the_same_bits(cache):
    first = run_graph(graph(), cache, ["text"])
    path = first.results["law_1"].entry.folder / "part_1.npy"
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    run_graph(graph(), cache, ["text"])  # the damaged file is not read, so nobody minds
    entry = first.results["sum"].entry
    (entry.folder / "contents.json").unlink()
    with pytest.warns(CacheWarning) as warned:
        second = run_graph(graph(), cache, ["text"])
    assert {r.name for r in second.records if not r.reused} == {"law_1", "sum"}
    assert sorted(str(w.message).split()[2].partition("-")[0] for w in warned) == ["law", "sum"]
    assert [r.content for r in first.records] == [r.content for r in second.records]


@pytest.mark.parametrize("name", ["content", "seconds", "peak_bytes", "ledger", "fields", "takes", "code", "libraries"])
@pytest.mark.parametrize("given", [None, [["x"]], {"x": {}}])
def test_a_result_whose_facts_are_not_those_of_a_stage_is_built_again(cache, name, given):
    entry = run_graph(graph(), cache, ["text"]).results["law_1"].entry
    if (name, given) in (("takes", {"x": {}}), ("fields", {"x": {}}), ("libraries", {"x": {}})):
        pytest.skip("of the right type")
    manifest_of(entry, lambda body: body["facts"].update({name: given}))
    explain(graph(widths=(8.0, 9.0)), cache)  # compares with it
    with pytest.warns(CacheWarning, match=f"{entry.name} is damaged"):
        outcome = run_graph(graph(), cache, ["text"])
    assert outcome.value("text") == "total 3.0"


def test_a_stored_result_that_cannot_be_read_is_one_sentence(cache):
    entry = run_graph(graph(), cache, ["law_1"]).results["law_1"].entry
    (entry.folder / "part_1.npy").write_bytes(b"no array")
    total = {"bytes": 8, "sha256": hashlib.sha256(b"no array").hexdigest()}
    manifest_of(entry, lambda body: body["files"].update({"part_1.npy": total}))
    with pytest.raises(WorkError, match=r"law_1: its stored result cannot be read .* Delete .* and repeat the command"):
        run_graph(graph(), cache, ["text"])


def test_without_a_usable_cache_the_work_goes_on(tmp_path):
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.warns(CacheWarning):
        outcome = run_graph(graph(widths=(3.0, 3.0)), Cache(tmp_path / "file" / "c"), ["text"])
    assert outcome.value("text") == "total 6.0"


def long_graph(count, seconds=0.4):
    return Graph(
        Step(name=f"s{n}", kind="slow", build=make_slowly, spec=seconds + n / 1000, seconds=9.0) for n in range(count)
    )


def test_long_stages_run_side_by_side(cache):
    outcome = run_graph(long_graph(3), cache, ["s0", "s1", "s2"], processes=2)
    processes = [outcome.value(f"s{n}")["process"] for n in range(3)]
    children = set(processes) - {os.getpid()}  # the last one is built here if both children ended at the same time
    assert len(children) == 2
    assert all(record.peak_bytes > 1e6 for record in outcome.records)


def test_children_without_further_work_have_ended_when_the_last_long_stage_runs(cache):
    before = [child.pid for child in psutil.Process().children()]  # of earlier tests: a tracker of shared memory
    last = Step(name="last", kind="last", build=count_children, spec=0, takes={"slow": ("s0", "s1")}, seconds=60.0)
    outcome = run_graph(Graph([*long_graph(2), last]), cache, ["last"], processes=2)
    assert os.getpid() not in {outcome.value(n)["process"] for n in ("s0", "s1")}
    assert set(outcome.value("last")["children"]) <= set(before)
    assert outcome.value("last")["slow"] == 2


@pytest.mark.parametrize(("processes", "begun"), [(2, ["sum ahead with 0.2", "sum"]), (1, ["sum"])])
def test_what_a_step_does_ahead_is_done_beside_others_and_its_failure_is_not_that_of_the_step(cache, processes, begun):
    """It takes what it names alone; in one process there is nobody beside whom it could be done."""
    quick = Step(name="quick", kind="slow", build=make_slowly, spec=0.2)
    last = Step(
        name="last", kind="last", build=finish, spec="sum", takes={"slow": ("s0", "s1"), "quick": "quick"},
        prepare=begin, prepare_takes=("quick",),
    )  # fmt: skip
    same = replace(last, name="same", takes={"last": "last"})  # calls the same code, which is prepared once
    outcome = run_graph(Graph([quick, *long_graph(2, 0.5), last, same]), cache, ["same"], processes=processes)
    assert outcome.value("last") == {"calls": begun}
    assert outcome.value("same") == {"calls": [*begun, "sum"]}


def test_short_steps_are_built_here_while_long_ones_are_built_elsewhere_and_their_failure_waits(cache):
    spare = Step(name="spare", kind="slow", build=make_slowly, spec=0.01)
    bad = Step(name="bad", kind="bad", build=make_nothing, spec="no picture")
    after = Step(name="after", kind="after", build=count_children, takes={"slow": ("spare",)})
    last = Step(name="last", kind="last", build=count_children, takes={"slow": ("bad",)})
    graph = Graph([*long_graph(2, 1.5), bad, spare, after, last])
    with pytest.raises(ValueError, match="no picture"):
        run_graph(graph, cache, graph.steps, processes=2)
    assert [status.name for status in explain(graph, cache) if status.action != "reuse"] == ["bad", "last"]
    outcome = run_graph(graph, cache, ["s0", "s1", "spare", "after"])
    assert all(record.reused for record in outcome.records)
    assert outcome.value("spare")["process"] == os.getpid()
    assert len(outcome.value("after")["children"]) >= 2


def test_a_child_that_dies_while_it_waits_for_work_is_replaced():
    with Processes(1) as pool:
        first = pool.submit(os.getpid).result()
        (child,) = pool._idle
        assert child.pid == first
        child.kill()
        child.wait()
        assert pool.submit(os.getpid).result() not in (os.getpid(), first)


def test_one_process_gives_the_same(cache):
    outcome = run_graph(long_graph(2, 0.0), cache, ["s0", "s1"], processes=1)
    assert {outcome.value(n)["process"] for n in ("s0", "s1")} == {os.getpid()}


def test_an_error_keeps_its_kind_and_names_the_stage_from_another_process_too(cache):
    stages = [
        Step(name=f"bad_{n}", kind="bad", build=make_nothing, spec=f"reason {n}", seconds=9.0 * n) for n in range(3)
    ]
    with pytest.raises(ValueError, match="reason 0") as here:
        run_graph(Graph(stages), cache, ["bad_0"])
    assert here.value.__notes__ == ["in step bad_0"]
    with pytest.raises(ValueError, match=r"reason [12]") as there:
        run_graph(Graph(stages), cache, ["bad_1", "bad_2"], processes=2)
    assert there.value.__notes__[0].startswith("in step bad_")


def test_an_error_that_cannot_leave_its_process_arrives_in_words(cache):
    stages = [Step(name=f"odd_{n}", kind="odd", build=fail_oddly, spec=n, seconds=9.0) for n in range(2)]
    with pytest.raises(WorkError, match="OddError: odd words"):
        run_graph(Graph(stages), cache, ["odd_0", "odd_1"], processes=2)


def test_a_process_that_dies_is_reported(cache):
    stages = [Step(name=f"dead_{n}", kind="dead", build=end_at_once, spec=n, seconds=9.0) for n in range(2)]
    with pytest.raises(WorkError, match=r"dead_\d: its process ended with exit code 9"):
        run_graph(Graph(stages), cache, ["dead_0", "dead_1"], processes=2)


def test_a_graph_refuses_wrong_order_and_repeated_names():
    with pytest.raises(ValueError, match="takes 'b'"):
        Graph([Step(name="a", kind="k", build=make_slowly, takes={"b": "b"})])
    with pytest.raises(ValueError, match="given twice"):
        Graph([Step(name="a", kind="k", build=make_slowly)] * 2)


def test_the_code_version_follows_imports():
    assert "fem.storage.records" in reachable("pipelines.engine.storage")
    assert "pipelines.scene.scene" in reachable("pipelines.scene.load_scene")  # imported inside functions
    assert "pipelines.scene.scene" not in reachable("pipelines.engine.storage")
    assert code_version("pipelines.engine.cache") != code_version("pipelines.engine.storage")


def test_the_code_version_finds_the_imports_that_the_syntax_tree_has():
    root = Path(code_version_module.__file__).parents[2]
    for path in (path for top in OWN_PACKAGES for path in (root / top).rglob("*.py")):
        own = ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__")
        names = set()
        for node in nodes(path):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                members = {f"{node.module}.{alias.name}" for alias in node.names}
                names |= {one for one in members if find_module(root, one)} or {node.module}
        ours = {name for name in names if name.partition(".")[0] in OWN_PACKAGES and find_module(root, name)}
        assert ours <= set(reachable(own)), own


def find_module(root, name):
    place = root.joinpath(*name.split("."))
    return place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()


def make_large(spec):
    return {"table": np.full(3_000_000, spec)}


def test_a_large_result_is_read_from_the_cache_and_not_held(cache):
    steps = [Step(name=f"s{n}", kind="large", build=make_large, spec=float(n)) for n in range(2)]
    outcome = run_graph(Graph(steps), cache, ["s0", "s1"], processes=1)
    assert [result.value for result in outcome.results.values()] == [None, None]
    assert outcome.value("s1")["table"].max() == 1.0
