"""`gearcase cache`: show, verify or clear the store of finished steps."""

from __future__ import annotations

import argparse
from collections import defaultdict
from itertools import chain

from pipelines.cli.command_line import Printed, argument
from pipelines.io.argument_types import days

ARGUMENTS = (
    argument(
        "action",
        choices=("info", "verify", "clear"),
        nargs="?",
        default="info",
        help="info: sizes by kind of step; verify: check and remove damaged entries; clear: remove (default info)",
    ),
    argument(
        "--older-than",
        metavar="DAYS",
        type=days,
        default=0.0,
        help="with clear: remove only entries that were not used for this number of days (default 0: all)",
    ),
)


def main(options: argparse.Namespace) -> Printed:
    """Show the size of the cache, verify its checksums, or clear it. The cache stores the results of computed steps,
    which all scenes reuse. After clearing, runs compute these steps again. Takes seconds.

    Example
    -------
    gearcase cache info
    ...
      casing               1 entry          0.0 MB
    ...
      all                  6 stored         6.2 MB
    """
    from pipelines.engine.cache import Cache
    from pipelines.io.errors import InputError

    if options.older_than and options.action != "clear":
        raise InputError(f"cache {options.action}: --older-than is an option of cache clear only. Delete it.")
    cache = Cache()
    if options.action == "clear":
        count, size = cache.clear(options.older_than)
        yield f"{count} entries removed, {size / 1e6:.1f} MB freed in {cache.folder}"
        return 0
    if options.action == "verify":
        intact, removed = cache.verify()
        yield from (f"removed {line}" for line in removed)
        yield f"{intact} entries are intact; {len(removed)} damaged ones removed"
        return 1 if removed else 0
    sizes: dict[str, list[int]] = defaultdict(list)
    for entry in cache.entries():
        sizes[entry.facts["kind"]].append(entry.bytes)
    yield str(cache.folder)
    for kind, found in sorted(sizes.items()):
        yield f"  {kind:16} {len(found):5} {'entry  ' if len(found) == 1 else 'entries'} {sum(found) / 1e6:10.1f} MB"
    code = [path.stat().st_size for path in cache.compiled()]
    if code:
        yield f"  {'compiled code':16} {len(code):5} files   {sum(code) / 1e6:10.1f} MB"
    stored = [*code, *chain.from_iterable(sizes.values())]
    yield f"  {'all':16} {len(stored):5} stored  {sum(stored) / 1e6:10.1f} MB"
    return 0
