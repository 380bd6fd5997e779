"""Squeeze film: the oil that approaching flanks press out of their gap.

Reynolds' equation for a long cylinder of radius R at the distance h from a plane, approaching at v, without suction:

    F = 12 pi eta b v (R/2h)^1.5 = 3 sqrt(2) pi eta b v (R/h)^1.5,   v > 0;   F = 0 where the flanks part.

The flanks of both teeth at the pitch point make the cylinder, b is the mean length of all contact lines. h is the gap
in which no tooth touches, floored by the roughness h_0. Where the flanks carry a force F_c the film is squeezed out: it
fades as F_0/(F_0 + F_c), F_0 the force that presses the teeth together by h_0; in a loaded mesh the damping of the mesh
itself counts (`mbd.forces.flank`). Thinning of the oil by pressure and the sliding of the flanks are left out.

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
from mbd.parts.assembly import Assembly

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
    """One per flank, where the mesh has a film."""
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
