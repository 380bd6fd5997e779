"""The toothed ring meshed as a whole, tooth by tooth: what the condensed ring is held against."""

import numpy as np
from scipy.sparse.linalg import splu

from fem.elements.sections import stiffness

YOUNG, POISSON = 206e9, 0.3


def whole_ring(mesh, missing=None, slit_on=None):
    """Stiffness of the ring meshed tooth by tooth with the bore fixed, and node numbers (z, nodes) in it.

    Tooth `missing` is cut off above the fillet; the slit of the mesh is open on tooth `slit_on`, elsewhere welded.
    """
    z, n = mesh.teeth, len(mesh.points)
    number = np.arange(z * n).reshape(z, n)
    for tooth in range(z):  # the low cut of the next sector is the high cut of this one
        number[(tooth + 1) % z, mesh.cut_low] = number[tooth, mesh.cut_high]
        number[(tooth + 1) % z, mesh.cut_bore[0]] = number[tooth, mesh.cut_bore[1]]
    angle = 2 * np.pi * np.arange(z) / z
    turn = np.stack([np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)], axis=-1).reshape(z, 2, 2)
    points = np.zeros((z * n, 2))
    points[number] = np.einsum("ni,tij->tnj", mesh.points, turn)
    keep = np.ones((z, len(mesh.elements)), dtype=bool)
    if missing is not None:
        foot = np.linalg.norm(mesh.points[mesh.flank[0]])
        keep[missing % z] = np.linalg.norm(mesh.points[mesh.elements[:, 4]], axis=1) < foot
    whole = mesh.closed().elements
    quads = [mesh.elements if t == slit_on else whole for t in range(z)]
    elements = np.concatenate([number[t][quads[t][keep[t]]] for t in range(z)])
    matrix = stiffness(points, elements, YOUNG, POISSON, mesh.twist)
    components = matrix.shape[0] // len(points)
    used = np.isin(np.arange(z * n), elements)
    used[number[:, np.concatenate([mesh.bore, mesh.cut_bore])]] = False
    return matrix, np.repeat(used, components), number, turn, components


def whole_ring_response(mesh, loads, teeth, missing=None, slit_on=None):
    """As `ring_response`, from the whole ring, for loads on tooth 0 seen on the given teeth."""
    matrix, free, number, turn, components = whole_ring(mesh, missing, slit_on)
    local = loads.toarray().reshape(len(mesh.points), components, -1)

    def on(tooth):
        out = np.zeros((number.size, components, local.shape[2]))
        moved = local.copy()
        moved[:, :2] = np.einsum("nip,ij->njp", local[:, :2], turn[tooth % len(turn)])
        out[number[tooth % len(turn)]] = moved
        return out.reshape(-1, local.shape[2])[free]

    answer = splu(matrix[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(on(0))
    return {tooth: on(tooth).T @ answer for tooth in teeth}
