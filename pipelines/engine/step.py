"""Steps, the parts of a computation, and the keys of their stored results.

A step is a function with its `spec`, the only part of the machine model that it can read, and the steps whose results
are its inputs, by the names of its parameters. Its key is the digest of the spec, of the content of the inputs, of its
code and of the libraries it names. If an input is built again with the same content, the key stays the same.
"""

from __future__ import annotations

import hashlib
import importlib
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pipelines.engine.cache import Cache, Entry
from pipelines.engine.code_version import code_version, library_versions
from pipelines.engine.storage import class_modules, digest, flat
from pipelines.io.toml_text import format_value

FIRST = "first run"
LONG_SECONDS = 3.0  # steps that are expected to take longer may be built in a child process
_FACTS: dict[str, type | tuple[type, ...]] = {
    "content": str,
    "seconds": (int, float),
    "peak_bytes": int,
    "ledger": dict,
    "fields": dict,
    "takes": dict,
    "code": str,
    "libraries": dict,
}


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step of a run: ``build(spec, **results of takes)``; a mapping as `spec` holds arguments of `build` by name.

    `kind` names the cache entries; steps of one kind with equal inputs share one entry. `build` is a function of a
    module (not a lambda); its counts (`fem.storage.ledger`) are stored with the result. `takes` maps parameters of
    `build` to the names of the steps whose results they receive; several names give a list. `seconds` is the expected
    time; long steps that are independent run in parallel.
    """

    name: str
    kind: str
    build: Callable[..., Any]
    spec: Any = None
    takes: Mapping[str, str | Sequence[str]] = field(default_factory=dict)
    modules: tuple[str, ...] = ()  # further modules on whose code the result depends; those that `build` imports do too
    libraries: tuple[str, ...] = ("numpy",)
    seconds: float = 0.1
    streams: bool = False  # `build` takes a `folder` for arrays too large for memory; None if none can be written
    enough: str = ""  # a number in `spec`; a stored result for a larger number can also be used
    prepare: Callable[..., None] | None = None  # ``prepare(spec, *results)`` compiles while other steps are built
    prepare_takes: tuple[str, ...] = ()
    compiles: Mapping[str, float] = field(default_factory=dict)  # s to compile, by prefix of the name of stored code

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of all steps whose results are inputs."""
        return _each(self.takes)

    def received(self, value: Callable[[str], Any]) -> dict[str, Any]:
        """Arguments of `build`; `value` returns the result of a step by its name."""
        return {
            key: value(names) if isinstance(names, str) else list(map(value, names))
            for key, names in self.takes.items()
        }

    @cached_property
    def code(self) -> str:
        """Version of the code of the build, of the modules it names, and of the classes in the spec."""
        return code_version(self.build.__module__, *self.modules, *sorted(class_modules(self.spec)))

    @cached_property
    def _spec_digest(self) -> str:
        return digest(self.spec)

    def load(self) -> str:
        """Import the modules that it names before the build; the version of the code."""
        for module in self.modules:
            importlib.import_module(module)
        return self.code

    def facts(self, contents: Mapping[str, str]) -> dict[str, Any]:
        """Everything that determines the result, in comparable form; `contents` are digests by step name."""
        return {**self._inputs(contents), "fields": flat(self.spec)}

    def _inputs(self, contents: Mapping[str, str]) -> dict[str, Any]:
        return {
            "kind": self.kind,
            "spec": self._spec_digest,
            "takes": self.received(contents.__getitem__),
            "code": self.code,
            "libraries": library_versions(*self.libraries),
        }

    def key(self, contents: Mapping[str, str]) -> str:
        """SHA-256 digest of everything that determines the result."""
        return hashlib.sha256(json.dumps(self._inputs(contents), sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True)
class Unkept:
    """Result of a step that must not be stored.

    It is incomplete in a way that another attempt may avoid, as a picture that was not rendered for lack of memory.
    """

    value: Any


@dataclass(frozen=True, kw_only=True)
class StepRecord:
    """Record of a step in a run. Seconds, memory and ledger are those of its build, also if the result was reused.

    `libraries` are the versions of the libraries on which its result depends.
    """

    name: str
    kind: str
    key: str
    content: str
    reused: bool
    seconds: float
    peak_bytes: int
    ledger: Mapping[str, int]
    libraries: Mapping[str, str]


@dataclass(frozen=True)
class StepStatus:
    """Expected action for a step: "reuse", "build", or "follow", which depends on the content of its inputs."""

    name: str
    action: str
    reason: str
    first: bool = False  # no stored result to compare with


class Graph:
    """Steps in an order in which each follows its inputs.

    Raises ValueError if a name is repeated or a step precedes one of its inputs.
    """

    def __init__(self, steps: Iterable[Step]) -> None:
        self.steps: dict[str, Step] = {}
        for step in steps:
            missing = [name for name in step.inputs if name not in self.steps]
            if missing or step.name in self.steps:
                wrong = f"takes {missing[0]!r}, which is no earlier step" if missing else "is given twice"
                raise ValueError(f"step {step.name!r} {wrong}")
            self.steps[step.name] = step

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps.values())

    def needed(self, requested: Iterable[str]) -> Graph:
        """The graph of the requested steps and all their direct and indirect inputs."""
        keep, waiting = set(), list(requested)
        while waiting:
            name = waiting.pop()
            if name not in keep:
                keep.add(name)
                waiting.extend(self.steps[name].inputs)
        return Graph(step for step in self if step.name in keep)

    def without(self, name: str) -> Graph:
        """The graph without a step and all steps that depend on it."""
        dropped = {name}
        for step in self:
            if not dropped.isdisjoint(step.inputs):
                dropped.add(step.name)
        return Graph(step for step in self if step.name not in dropped)


def seconds_to_the_end(tasks: Iterable[tuple[str, float, Sequence[str]]]) -> dict[str, float]:
    """Seconds of each task with the longest chain of tasks that wait for it.

    Parameters
    ----------
    tasks : name, seconds, and names of the tasks for which it waits, which precede it
    """
    chain: dict[str, float] = {}
    behind: dict[str, float] = {}
    for name, seconds, takes in reversed(list(tasks)):
        chain[name] = seconds + behind.get(name, 0.0)
        behind |= {other: max(behind.get(other, 0.0), chain[name]) for other in takes}
    return chain


def stored(step: Step, cache: Cache, contents: Mapping[str, str], *, thorough: bool) -> Entry | None:
    """The stored entry for a step: with its key, or with the next larger number if the step allows it by `enough`.

    Parameters
    ----------
    step, cache : the step, and the cache of results
    contents : digests of the inputs by the names of their steps
    thorough : verify the checksums of all files, as is necessary before they are read
    """
    found = cache.find(step.kind, step.key(contents), thorough=thorough)
    if found is not None and not whole(found):
        cache.discard(found.folder, "its facts are not those of a step")
        found = None
    if found is not None or not step.enough:
        return found
    facts = step.facts(contents)
    requested = facts["fields"][step.enough]
    serving = []
    for entry in filter(whole, cache.entries(step.kind)):
        given = entry.facts["fields"].get(step.enough)
        same = all(entry.facts[name] == facts[name] for name in ("takes", "code", "libraries"))
        others = {**entry.facts["fields"], step.enough: requested}
        if same and others == facts["fields"] and isinstance(given, int | float) and given > requested:
            serving.append((given, entry.facts["key"]))
    return cache.find(step.kind, min(serving)[1], thorough=thorough) if serving else None


def stored_contents(
    steps: Iterable[Step],
    cache: Cache,
    known: Mapping[str, str],
    like: Callable[[Step, Cache, Mapping[str, str]], Entry | None] = lambda step, cache, contents: None,
) -> tuple[dict[str, str], list[Step]]:
    """Digests by name of the results that are known or stored, and the missing steps that could be built now.

    Parameters
    ----------
    steps, cache : each step after its inputs, and the cache of results
    known : digests by name
    like : a stored result that is expected to be that of a step, if its own is not stored
    """
    contents, missing = dict(known), []
    for step in steps:
        if step.name not in contents and all(name in contents for name in step.inputs):
            entry = stored(step, cache, contents, thorough=False) or like(step, cache, contents)
            if entry is None:
                missing.append(step)
            else:
                contents[step.name] = entry.facts["content"]
    return contents, missing


def explain(graph: Graph, cache: Cache) -> list[StepStatus]:
    """For each step whether a run would reuse or build it, and why; nothing is built."""
    contents: dict[str, str] = {}
    out = []
    planned: dict[str, str] = {}
    for step in graph:
        waiting = [name for name in step.inputs if name not in contents]
        if waiting:
            nearest = _nearest(step, cache, step.facts({name: contents.get(name, "") for name in step.inputs}))
            own = [FIRST] if nearest is None else [d for d in nearest if not d.startswith("another")]  # yet unknown
            reason = "; ".join([f"after {', '.join(waiting)}", *own])
            out.append(StepStatus(step.name, "build" if own else "follow", reason, first=nearest is None))
            continue
        key = step.key(contents)
        entry = stored(step, cache, contents, thorough=False)
        if entry is not None:
            contents[step.name] = entry.facts["content"]
            more = "" if entry.facts["key"] == key else f"stored with a larger {step.enough}"
            out.append(StepStatus(step.name, "reuse", more))
        elif key in planned:
            out.append(StepStatus(step.name, "reuse", f"the same as {planned[key]}"))
        else:
            planned[key] = step.name
            differences = _nearest(step, cache, step.facts(contents))
            reason = FIRST if differences is None else "; ".join(differences) or "its stored result was removed"
            out.append(StepStatus(step.name, "build", reason, first=differences is None))
    return out


def _nearest(step: Step, cache: Cache, facts: Mapping[str, Any]) -> list[str] | None:
    """Differences to the entry with the fewest; None without entries with the same kinds of inputs.

    Among equals, an entry of a step of the same name is preferred, then the newest.
    """
    ranked = [
        (len(found), entry.facts.get("step") != step.name, found)
        for entry in filter(whole, cache.entries(step.kind))
        if (found := _differences(step, entry, facts)) is not None
    ]
    return min(ranked, key=lambda item: item[:2])[2] if ranked else None


def _differences(step: Step, entry: Entry, facts: Mapping[str, Any]) -> list[str] | None:
    """Differences between a step and a stored one; None if that has other inputs or belongs to another scene."""
    old = entry.facts
    before, after = old["fields"], facts["fields"]
    changed = [
        path
        for path in sorted(before.keys() | after.keys())
        if before.get(path) != after.get(path) or (path in before) != (path in after)
    ]
    were, are = _each(old["takes"]), _each(facts["takes"])
    most = max(3, min(10, len(after) // 4))  # values that may differ between variants of one scene
    if old["takes"].keys() != facts["takes"].keys() or len(were) != len(are) or len(changed) > most:
        return None
    out = [f"{path or 'input'} {_change(before, after, path)}" for path in changed]
    pairs = zip(step.inputs, were, are, strict=True)
    out += [f"another result of {name}" for name, was, now in pairs if was != now]
    if old["code"] != facts["code"]:
        out.append("its code changed")
    versions = facts["libraries"].items()
    out += [f"{lib} {old['libraries'].get(lib)} -> {now}" for lib, now in versions if old["libraries"].get(lib) != now]
    return out


def _each(taken: Mapping[str, str | Sequence[str]]) -> tuple[str, ...]:
    """Names or digests in one sequence."""
    return tuple(one for ones in taken.values() for one in ([ones] if isinstance(ones, str) else ones))


def whole(entry: Entry) -> bool:
    """True if an entry has the facts of a step; other entries were not stored by a step."""
    facts = entry.facts
    typed = all(isinstance(facts.get(name), kind) for name, kind in _FACTS.items())
    return typed and all(isinstance(count, int) for count in facts["ledger"].values())


def _change(before: Mapping[str, Any], after: Mapping[str, Any], path: str) -> str:
    """The values of a field before and after, with six digits if that is enough to distinguish them."""
    short = [_shown(fields, path, _rounded) for fields in (before, after)]
    was, now = short if short[0] != short[1] else [_shown(fields, path) for fields in (before, after)]
    return f"{was} -> {now}"


def _shown(fields: Mapping[str, Any], path: str, simplified: Callable[[Any], Any] = lambda value: value) -> str:
    if path not in fields:
        return "(none)"
    text = "none" if fields[path] is None else format_value(simplified(fields[path]))
    return text if len(text) <= 40 else f"{text[:37]}..."


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value
