"""Order of elimination of a sparse symmetric matrix: nested dissection, elimination tree, supernodes.

METIS dissects the graph of the matrix. The elimination tree gives the rows of the non-zero entries in each column of
the factor without forming it. Columns with nearly the same rows are joined to supernodes, so that the factorisation
works on dense blocks. All of this is done on groups of unknowns (the nodes of a mesh).

References: Karypis & Kumar (1998), SIAM J. Sci. Comput. 20(1), 359-392; Liu (1990), SIAM J. Matrix Anal. Appl. 11(1),
134-172 (elimination tree); Ashcraft & Grimes (1989), ACM TOMS 15(4), 291-309 (relaxed supernodes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from fem.numerics.compiled import stored

_OPENED = 30  # upper bound of the subtrees that are divided to find two halves


@dataclass(frozen=True, eq=False)
class Elimination:
    """Supernodes in the order of elimination; all but `order` are in numbers of the reordered unknowns."""

    order: np.ndarray  # (n,) old number of each new unknown
    starts: np.ndarray  # (supernode + 1,) first unknown of each
    rows: tuple[np.ndarray, ...]  # later unknowns with entries in the columns of the supernode, ascending
    children: tuple[tuple[int, ...], ...]  # supernodes whose update matrices are added to it
    split: tuple[int, int]  # supernodes before the first are not coupled with those from it to before the second


def plan_elimination(K: sp.spmatrix, block: int = 1) -> Elimination:
    """Supernodes of a symmetric sparse matrix (n, n) with groups of `block` unknowns; the last may be smaller."""
    graph = group_graph(K, block)
    order = dissect(graph)
    graph = _reordered(graph, order)
    parent = _tree(graph.indptr, graph.indices)
    post = _postorder(parent)
    order, graph = order[post], _reordered(graph, post)
    place = np.empty_like(post)
    place[post] = np.arange(len(post))
    parent = np.where(parent[post] >= 0, place[parent[post]], -1)
    owner, above = _supernodes(parent, _column_counts(graph.indptr, graph.indices, parent))
    by_owner = np.argsort(owner, kind="stable")
    order, graph, owner = order[by_owner], _reordered(graph, by_owner), owner[by_owner]
    starts = np.append(np.flatnonzero(np.diff(owner, prepend=-1)), len(order))
    rows, children = _structure(graph, starts, above)
    turn, split = _halves(np.diff(starts), rows, children)
    groups, turned = np.split(np.arange(len(order)), starts[1:-1]), np.argsort(turn)
    by_turn = np.concatenate([groups[s] for s in turn])
    place, order = np.argsort(by_turn), order[by_turn]
    first = firsts(K.shape[0], block)
    reordered = np.append(0, np.cumsum(np.diff(first)[order]))
    return Elimination(
        order=members(order, first),
        starts=reordered[np.append(0, np.cumsum(np.diff(starts)[turn]))],
        rows=tuple(members(np.sort(place[rows[s]]), reordered) for s in turn),
        children=tuple(tuple(int(turned[c]) for c in children[s]) for s in turn),
        split=split,
    )


def _halves(
    width: np.ndarray, rows: list[np.ndarray], children: tuple[tuple[int, ...], ...]
) -> tuple[np.ndarray, tuple[int, int]]:
    """Order of the supernodes by two independent halves of the tree and the top above both; ends of the two halves.

    The subtree with the most work is divided: its root is moved to the top. Of all divisions, that with the least time
    on two threads is taken. Children stay before their parents.
    """
    work = np.array([float(w * (w + len(r))) for w, r in zip(width, rows, strict=True)])
    below = work.copy()
    owner = np.full(len(work), -1)
    for s, own in enumerate(children):
        below[s] += below[list(own)].sum()
        owner[list(own)] = s
    trees, top = [int(s) for s in np.flatnonzero(owner < 0)], 0.0
    best, half_of, shortest = np.zeros(0, int), np.zeros(0, int), np.inf
    for _ in range(_OPENED):
        trees.sort(key=lambda s: (-below[s], s))
        load, half = [0.0, 0.0], np.zeros(len(trees), int)
        for place, tree in enumerate(trees):
            half[place] = int(load[1] < load[0])
            load[half[place]] += below[tree]
        if top + max(load) < shortest:
            best, half_of, shortest = np.array(trees), half, top + max(load)
        heaviest = trees.pop(0)
        top += work[heaviest]
        trees += children[heaviest]
        if not trees:
            break
    part = np.full(len(work), 2)
    part[best] = half_of
    for s in range(len(work) - 1, -1, -1):
        if owner[s] >= 0 and part[owner[s]] < 2:
            part[s] = part[owner[s]]
    first, second = int((part == 0).sum()), int((part == 1).sum())
    return np.argsort(part, kind="stable"), (first, first + second)


def rows_of(K: sp.spmatrix) -> sp.csr_matrix:
    """A symmetric matrix by rows; one stored by columns is not converted, since its columns are its rows."""
    return sp.csr_matrix(K.T if K.format == "csc" else K)


def group_graph(K: sp.spmatrix, block: int) -> sp.csr_matrix:
    """Adjacency matrix of groups of `block` unknowns, without the diagonal."""
    K, first = rows_of(K), firsts(K.shape[0], block)
    n, size = K.shape[0], len(first) - 1
    touched = sp.csr_matrix((np.ones(K.nnz, np.int32), K.indices // block, K.indptr), shape=(n, size))
    gather = sp.csr_matrix((np.ones(n, np.int32), np.arange(n), first), shape=(size, n))
    graph = sp.csr_matrix(gather @ touched)
    graph = sp.csr_matrix(graph + graph.T)  # an entry may have cancelled to 0 on one side of the diagonal only
    graph -= sp.diags(graph.diagonal(), dtype=np.int32)
    graph.eliminate_zeros()
    graph.sort_indices()
    return graph


def dissect(graph: sp.csr_matrix) -> np.ndarray:
    """Fill-reducing order of the vertices of a graph by METIS nested dissection."""
    import pymetis

    if graph.nnz == 0:
        return np.arange(graph.shape[0])
    adjacency = pymetis.CSRAdjacency(adj_starts=graph.indptr, adjacent=graph.indices)
    return np.asarray(pymetis.nested_dissection(adjacency)[0])


def firsts(n: int, block: int) -> np.ndarray:
    """The first unknown of each group of `block`, and n."""
    return np.minimum(np.arange(0, n + block, block), n)


def members(groups: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The unknowns of groups, one group after the other; group g has those from `first[g]` to `first[g + 1] - 1`."""
    count = first[groups + 1] - first[groups]
    return np.arange(count.sum()) + np.repeat(first[groups] + count - np.cumsum(count), count)


def _reordered(graph: sp.csr_matrix, order: np.ndarray) -> sp.csr_matrix:
    graph = sp.csr_matrix(graph[order][:, order])
    graph.sort_indices()
    return graph


def _supernodes(parent: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Supernode (n,) of each column of a postordered tree, numbered in order, and the parent of each (-1: none)."""
    n = len(parent)
    begins = np.ones(n, bool)  # a column continues a supernode if the column before has one row more: itself
    begins[1:] = ~((parent[:-1] == np.arange(1, n)) & (counts[:-1] == counts[1:] + 1))
    start = np.flatnonzero(begins)
    column_owner = np.cumsum(begins) - 1
    width = np.diff(np.append(start, n))
    last = start + width - 1
    above = np.where(parent[last] >= 0, column_owner[parent[last]], -1)
    joined = _join(width, counts[start], above)
    kept = np.flatnonzero(joined == np.arange(len(joined)))
    number = np.full(len(joined), -1)
    number[kept] = np.arange(len(kept))
    upper = above[kept]
    return number[joined[column_owner]], np.where(upper >= 0, number[joined[upper]], -1)


def _structure(
    graph: sp.csr_matrix, starts: np.ndarray, above: np.ndarray
) -> tuple[list[np.ndarray], tuple[tuple[int, ...], ...]]:
    """Rows after each supernode, from its own entries and from the update matrices of its children; the children."""
    children: list[list[int]] = [[] for _ in above]
    rows: list[np.ndarray] = []
    for number, upper in enumerate(above):
        first, end = starts[number], starts[number + 1]
        own = graph.indices[graph.indptr[first] : graph.indptr[end]]
        found = np.unique(np.concatenate([own, *(rows[child] for child in children[number])]))
        rows.append(found[found >= end])
        if upper >= 0:
            children[upper].append(number)
    return rows, tuple(tuple(c) for c in children)


@stored(__file__)
def _tree(indptr: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """Parent of each column in the elimination tree, -1 for a root."""
    n = len(indptr) - 1
    parent, ancestor = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for i in range(n):
        for p in range(indptr[i], indptr[i + 1]):
            j = np.int64(indices[p])
            while j != -1 and j < i:
                above = ancestor[j]
                ancestor[j] = i
                if above == -1:
                    parent[j] = i
                j = above
    return parent


@stored(__file__)
def _postorder(parent: np.ndarray) -> np.ndarray:
    """Postorder of the columns: each subtree is contiguous and precedes its root."""
    n = len(parent)
    first, sibling = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    for j in range(n - 1, -1, -1):
        if parent[j] >= 0:
            sibling[j] = first[parent[j]]
            first[parent[j]] = j
    order, stack = np.empty(n, np.int64), np.empty(n, np.int64)
    done = 0
    for root in range(n):
        if parent[root] != -1:
            continue
        depth, stack[0] = 0, root
        while depth >= 0:
            child = first[stack[depth]]
            if child == -1:
                order[done] = stack[depth]
                done, depth = done + 1, depth - 1
            else:
                first[stack[depth]] = sibling[child]
                depth += 1
                stack[depth] = child
    return order


@stored(__file__)
def _column_counts(indptr: np.ndarray, indices: np.ndarray, parent: np.ndarray) -> np.ndarray:
    """Entries in each column of the factor, with the diagonal: row i holds the paths from its entries up to i."""
    n = len(parent)
    counts, mark = np.ones(n, np.int64), np.full(n, -1, np.int64)
    for i in range(n):
        mark[i] = i
        for p in range(indptr[i], indptr[i + 1]):
            j = np.int64(indices[p])
            while j != -1 and j < i and mark[j] != i:
                counts[j] += 1
                mark[j] = i
                j = parent[j]
    return counts


@stored(__file__)
def _join(width: np.ndarray, height: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Supernode to which each one is joined, as long as few zeros are stored; otherwise its own number."""
    width, height, zeros = width.copy(), height.copy(), np.zeros(len(width))
    target = np.arange(len(width))
    for s in range(len(width)):
        p = above[s]
        if p < 0:
            continue
        together, tall = width[s] + width[p], width[s] + height[p]
        stored = zeros[s] + zeros[p] + width[s] * (tall - height[s])
        share = stored / (together * (together + 1) / 2.0 + together * (tall - together))
        allowed = 1.0 if together <= 4 else 0.5 if together <= 16 else 0.15 if together <= 48 else 0.05
        if share <= allowed:
            target[s], width[p], height[p], zeros[p] = p, together, tall, stored
    for s in range(len(width) - 1, -1, -1):
        target[s] = target[target[s]]
    return target
