"""Squeeze film: force of the oil in the gap between approaching flanks.

Reynolds' equation for a long cylinder of radius R at the distance h from a plane, with the approach speed v and without
negative pressure, gives

    F = 12 pi eta b v (R/2h)^1.5 = 3 sqrt(2) pi eta b v (R/h)^1.5   for v > 0,   F = 0 for v <= 0.

R is the radius of relative curvature at the pitch point, b the mean length of all contact lines. h is the gap between
the flanks, 0 in contact, plus the roughness h_0. Under a contact force F_c the film force is multiplied by
F_0/(F_0 + F_c), where F_0 deflects the teeth by h_0. In a loaded mesh the damping of the mesh (`mbd.forces.flank`) thus
replaces the film. The effect of pressure on the viscosity and the sliding of the flanks are neglected.

References
----------
Brancati, Rocca & Russo (2005), Proc. IMechE D 219, 817-826; Theodossiades, Tangasawi & Rahnejat (2007), J. Sound Vib.
303, 632-658; Hamrock, Schmid & Jacobson (2004), Fundamentals of Fluid Film Lubrication, section 11.3 (normal approach).
"""

from __future__ import annotations

from collections.abc import Iterator

from fem.contact.teeth import least_clearance
from mbd.elements.element import Element, rule
from mbd.forces.flank import SIDES, flank_name
from mbd.parts.linear_reference import Assembly

STRENGTH, ROUGHNESS, TOUCHING, FADING = range(4)


@rule(__file__)
def film_rule(values, motion, answer):
    """Force on the approach of a flank; reads the force of its contact."""
    v = motion.v[0]
    if v <= 0.0:
        return
    gap = values[TOUCHING] - motion.u[0]
    h = values[ROUGHNESS] + max(gap, 0.0)
    carried = motion.read_force[0]
    fading = values[FADING] / (values[FADING] + carried)
    damper = values[STRENGTH] / (h**1.5) * fading
    answer.lost[0] = damper * v
    answer.lost_by_v[0, 0] = damper
    if gap > 0.0:
        answer.lost_by_u[0, 0] = 1.5 * damper * v / h
    for column in range(2):
        slope = motion.read_stiffness[0, column] / (values[FADING] + carried)
        answer.lost_by_u[0, 1 + column] = -damper * v * slope


def elements(assembly: Assembly) -> Iterator[Element]:
    """One element for each flank of the meshes with a film."""
    flanks = {element.name: element for element in assembly.elements}
    for mesh in assembly.machine.meshes:
        film = mesh.film
        if film is None:
            continue
        for side, law in enumerate((mesh.drive, mesh.coast)):
            contact = flanks[flank_name(mesh.name, side)]
            stiffness = flanks[flank_name(mesh.name, 0)].stiffness[0]
            touching = least_clearance(law, *mesh.terms[side]) + (mesh.backlash if side else 0.0)
            yield Element(
                kind="film",
                name=f"{mesh.name} film:{SIDES[side]}",
                part=f"{mesh.name} film",
                rule=film_rule,
                values=(film.strength, film.roughness, touching, film.roughness * stiffness),
                rows=contact.rows[:1],
                row_names=("delta",),
                scale=(assembly.mesh_loads[mesh.name],),
                reads=(contact.name,),
            )
