"""One step built in this process: its time, its memory, what it counted, and its result in the cache."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from fem.numerics.compiled_files import compiled_folder
from fem.processes.executor import THREAD_VARIABLES
from fem.storage.cache_folder import warn_without
from fem.storage.ledger import counting
from pipelines.engine.cache import Cache, Entry
from pipelines.engine.step import Step, StepRecord, Unkept
from pipelines.engine.storage import StorageError, digest, reader, save_value
from pipelines.io.errors import WorkError


@dataclass(frozen=True)
class Result:
    """A step's record with the way to its value: an entry of the cache, or the value itself if none was stored."""

    record: StepRecord
    entry: Entry | None
    value: Any = None

    def load(self) -> Any:
        """The value, read from the cache if it is there."""
        if self.entry is None or self.value is not None:
            return self.value
        try:
            return reader(self.entry.folder)()
        except OSError as error:
            raise WorkError(
                f"step {self.record.name}: its stored result {self.entry.name} was removed during the run "
                f"({error}). Repeat the command, and do not clear the cache meanwhile."
            ) from error
        except (ValueError, TypeError, KeyError) as error:
            raise WorkError(
                f"step {self.record.name}: its stored result cannot be read ({error}). Delete "
                f"{self.entry.folder} and repeat the command."
            ) from error

    def stored(self) -> Result:
        """The same without the value, where the cache holds it."""
        return self if self.entry is None else Result(self.record, self.entry)


@dataclass(frozen=True)
class Event:
    """What happens to a step of a run: it starts, a share of it (0 to 1) is done, or its result is there."""

    step: Step
    share: float | None = None
    result: Result | None = None


def build_here(step: Step, key: str, upstream: Mapping[str, Result], cache: Cache) -> Result:
    """Build one step in this process and store it.

    Parameters
    ----------
    step, key : the step, and the key of its result
    upstream : results by the names of the steps that it takes
    cache : where the result is stored
    """
    inputs = step.received(lambda name: upstream[name].load())
    if not step.streams:
        return _built(step, key, upstream, cache, inputs)
    with cache.workplace() as folder:
        try:
            result = _built(step, key, upstream, cache, inputs, folder=folder)
        except OSError as error:
            if folder is None:
                raise
            warn_without(cache.folder, error)
            return _built(step, key, upstream, cache, inputs, folder=None)
        # what the folder holds ends with it: the entry has it, too, or else memory must
        return result.stored() if result.entry else replace(result, value=result.value.in_memory())


def _built(
    step: Step, key: str, upstream: Mapping[str, Result], cache: Cache, inputs: dict[str, Any], **place: Path | None
) -> Result:
    start, code = time.perf_counter(), _written(compiled_folder())
    with peak_memory() as peak, counting() as counts:
        try:
            given = ((), step.spec) if isinstance(step.spec, Mapping) else ((step.spec,), {})
            made = step.build(*given[0], **given[1], **inputs, **place)
        except Exception as error:
            error.add_note(f"in step {step.name}")
            raise
    value = made.value if isinstance(made, Unkept) else made
    facts = {
        **step.facts({name: upstream[name].record.content for name in step.inputs}),
        "content": digest(value),
        "seconds": round(time.perf_counter() - start, 6),
        "estimate": step.seconds if code == _written(compiled_folder()) else 0.0,  # 0: some of the time was compiling
        "peak_bytes": peak.bytes,
        "ledger": dict(counts),
        "step": step.name,
    }
    entry = None
    try:
        if value is made:
            entry = cache.store(step.kind, key, lambda folder: save_value(folder, value), facts)
    except StorageError as error:
        raise WorkError(f"step {step.name}: its result cannot be stored: {error}") from error
    return Result(step_record(step, key, facts, reused=False), entry, value)


def _written(folder: Path) -> int:
    """When the folder changed last, ns; 0 if there is none."""
    return folder.stat().st_mtime_ns if folder.is_dir() else 0


def step_record(step: Step, key: str, facts: Mapping[str, Any], *, reused: bool) -> StepRecord:
    """The record of a step with the facts that are stored of it.

    Parameters
    ----------
    step, key, facts : the step, and key and facts of its result
    reused : the result was stored before this run
    """
    return StepRecord(
        name=step.name,
        kind=step.kind,
        key=key,
        content=facts["content"],
        reused=reused,
        seconds=facts["seconds"],
        peak_bytes=facts["peak_bytes"],
        ledger=facts["ledger"],
        libraries=facts["libraries"],
    )


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """BLAS and OpenMP limited to one thread, in libraries loaded before and after."""
    from threadpoolctl import threadpool_limits

    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    try:
        with threadpool_limits(1):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


@contextlib.contextmanager
def peak_memory() -> Iterator[SimpleNamespace]:
    """Largest resident memory of this process while the block runs, sampled every 50 ms: `bytes`."""
    import psutil

    process, peak, done = psutil.Process(), SimpleNamespace(bytes=0), threading.Event()

    def look() -> None:
        peak.bytes = max(peak.bytes, process.memory_info().rss)

    def watch() -> None:
        while not done.wait(0.05):
            look()

    thread = threading.Thread(target=watch, name="peak memory", daemon=True)
    thread.start()
    try:
        yield peak
    finally:
        done.set()
        thread.join()
        look()
