"""`gearcase cache`: show, verify or clear the store of finished steps."""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict


def main(options: argparse.Namespace) -> int:
    """info: sizes by kind; verify: check every entry, 1 if one was damaged; clear: remove."""
    from pipelines.engine.cache import Cache
    from pipelines.io.errors import InputError

    if options.older_than and options.action != "clear":
        raise InputError(f"cache {options.action}: --older-than is an option of cache clear only. Delete it.")
    cache = Cache()
    if options.action == "clear":
        count, size = cache.clear(options.older_than)
        sys.stdout.write(f"{count} entries removed, {size / 1e6:.1f} MB freed in {cache.folder}\n")
        return 0
    if options.action == "verify":
        intact, removed = cache.verify()
        sys.stdout.write("".join(f"removed {line}\n" for line in removed))
        sys.stdout.write(f"{intact} entries are intact; {len(removed)} damaged ones removed\n")
        return 1 if removed else 0
    sizes: dict[str, list[int]] = defaultdict(list)
    for entry in cache.entries():
        sizes[entry.facts["kind"]].append(entry.bytes)
    sys.stdout.write(f"{cache.folder}\n")
    for kind, found in sorted(sizes.items()):
        sys.stdout.write(f"  {kind:16} {len(found):5} entries {sum(found) / 1e6:10.1f} MB\n")
    code = [path.stat().st_size for path in cache.compiled()]
    if code:
        sys.stdout.write(f"  {'compiled code':16} {len(code):5} files   {sum(code) / 1e6:10.1f} MB\n")
    total = sum(sum(found) for found in sizes.values()) + sum(code)
    sys.stdout.write(f"  {'all':16} {sum(map(len, sizes.values())) + len(code):5} stored  {total / 1e6:10.1f} MB\n")
    return 0
