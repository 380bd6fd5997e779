"""Nodes of Nastran that move in frames of their own: the matrices become those along x, y and z."""

import numpy as np
import pytest

pytest.importorskip("pyyeti")

from fem.casing.imported.imported_body import MatrixError, imported_body
from fem.casing.imported.matrix_checks import check_matrices, rigid_motion
from fem.casing.imported.matrix_files import MatrixFiles, read_body
from fem.casing.imported.nastran import superelement_equations

PLACES = np.array([[0.0, 0.0, 0.0], [3.0, 1.0, 0.5], [1.0, 4.0, 2.0], [0.5, 1.0, 3.0]])
CORD = {  # system: card by its origin, a point on its third axis, and one in the plane of the first and the third
    10: "CORD2R,10,0,1.0,0.0,0.0,1.0,1.0,0.0\n,2.0,0.0,0.0",
    20: "CORD2C,20,0,0.0,0.0,0.0,0.0,0.0,1.0\n,1.0,0.0,0.0",
    30: "CORD2S,30,0,0.0,0.0,0.0,0.0,0.0,1.0\n,1.0,0.0,0.0",
}


def frames():
    """Of node 1 the basic one; of 2 a turned one, y along its third axis; of 3 cylindrical; of 4 spherical."""
    turned = np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    x, y, _ = PLACES[2]
    radial = np.array([x, y, 0.0]) / np.hypot(x, y)
    upright = np.array([0.0, 0.0, 1.0])
    cylindrical = np.column_stack([radial, np.cross(upright, radial), upright])
    outward = PLACES[3] / np.linalg.norm(PLACES[3])
    around = np.cross(upright, outward) / np.linalg.norm(np.cross(upright, outward))
    return [np.eye(3), turned, cylindrical, np.column_stack([outward, np.cross(around, outward), around])]


def free_body():
    """Random stiffness of four nodes with six unknowns each that lets the body move freely, and its mass."""
    rng = np.random.default_rng(4)
    body = imported_body("any", np.eye(24), np.eye(24), nodes=PLACES)
    rigid = np.linalg.qr(rigid_motion(body, np.zeros(3)))[0]
    free = np.eye(24) - rigid @ rigid.T
    stiff = rng.normal(size=(24, 24))
    return free @ (stiff @ stiff.T) @ free * 1e6, np.kron(np.eye(4), np.diag([2.0, 2.0, 2.0, 0.1, 0.1, 0.1]))


def written(folder, systems, cards=CORD):
    """The body with its equations in the frames of its nodes, in files."""
    K, M = free_body()
    turn = np.zeros((24, 24))
    for node, frame in enumerate(frames()):
        turn[6 * node :, 6 * node :][:6, :6] = np.kron(np.eye(2), frame)
    np.savez(folder / "k.npz", stiffness=turn.T @ K @ turn, mass=turn.T @ M @ turn)
    grids = [
        f"GRID,{number},0,{x!r},{y!r},{z!r},{system}"
        for number, ((x, y, z), system) in enumerate(zip(PLACES.tolist(), systems, strict=True), 1)
    ]
    (folder / "nodes.bdf").write_text("\n".join([*cards.values(), *grids]) + "\n", encoding="ascii")
    return MatrixFiles(stiffness=str(folder / "k.npz"), nodes=str(folder / "nodes.bdf"))


def test_equations_in_frames_of_the_nodes_become_those_along_x_y_and_z(tmp_path):
    body = read_body(written(tmp_path, [0, 10, 20, 30]))
    K, M = free_body()
    assert abs(body.stiffness - K).max() < 1e-9 * abs(K).max()
    assert abs(body.mass - M).max() < 1e-12 * abs(M).max()
    assert check_matrices(body).grounding < 1e-12


def test_without_the_frames_the_same_matrices_seem_grounded(tmp_path):
    body = read_body(written(tmp_path, [0, 0, 0, 0]))
    assert any("a rigid-body motion needs force" in words for words in check_matrices(body).wrong)


def test_a_frame_that_the_file_does_not_define_is_refused(tmp_path):
    cards = CORD | {10: "CORD1R,10,1,2,3"}
    with pytest.raises(MatrixError, match=r"nodes.bdf: nodes use the coordinate system 10, which no CORD2R"):
        read_body(written(tmp_path, [0, 10, 20, 30], cards))


def test_a_node_that_lacks_an_axis_of_its_frame_is_refused():
    with pytest.raises(MatrixError, match="node 2 moves in a local coordinate system and lacks an axis"):
        imported_body(
            "any",
            np.eye(5),
            np.eye(5),
            equations=np.array([[1, 1], [1, 2], [1, 3], [2, 1], [2, 2]]),
            nodes=PLACES[:2],
            frames=np.array(frames()[:2]),
        )


def test_the_cards_of_a_superelement_name_its_equations(tmp_path):
    """Two nodes of six unknowns and two modal coordinates."""
    path = tmp_path / "body.pch"
    path.write_text("EXTRN,3,123456,11,123,1995001,0,1995002,0\n", encoding="ascii")
    wanted = [*((3, axis) for axis in range(1, 7)), *((11, axis) for axis in (1, 2, 3)), (1995001, 0), (1995002, 0)]
    assert superelement_equations(path).tolist() == [list(one) for one in wanted]
    path.write_text("GRID,3,0,0.,0.,0.\n", encoding="ascii")
    with pytest.raises(MatrixError, match="has no EXTRN card"):
        superelement_equations(path)
