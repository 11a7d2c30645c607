"""The compiled element: four-node axisymmetric quadrilateral with element-wise mean dilatation (Q1/P0), finite strain.

The deviator depends on the displacement at the four Gauss points, the pressure on the mean dilatation J of the element (integral of det F
over its undeformed volume), and the yield limit on both (Cauchy yield: q of the Kirchhoff deviator <= J Y). The tangent is the exact
derivative; the derivative of the yield limit with J makes it unsymmetric.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel
from fem.stress import pressure, principal, principal_tangent, radial_return, volumetric_energy


@kernel
def deformation(displacement, nodes, gradient, hoop):  # type: ignore[no-untyped-def]
    """Deformation gradient (rr, rz, zr, zz, hoop) at one Gauss point."""
    f11, f12, f21, f22, f33 = 1.0, 0.0, 0.0, 1.0, 1.0
    for i in range(4):
        ur, uz = displacement[nodes[i], 0], displacement[nodes[i], 1]
        f11 += ur * gradient[i, 0]
        f12 += ur * gradient[i, 1]
        f21 += uz * gradient[i, 0]
        f22 += uz * gradient[i, 1]
        f33 += ur * hoop[i]
    return f11, f12, f21, f22, f33


@kernel
def trial_elastic(f, c):  # type: ignore[no-untyped-def]
    """Trial b = F Cp^-1 F^T (rr, zz, rz, hoop) from the deformation gradient and the stored Cp^-1 (rr, zz, rz, hoop)."""
    f11, f12, f21, f22, f33 = f
    b11 = f11 * f11 * c[0] + 2.0 * f11 * f12 * c[2] + f12 * f12 * c[1]
    b22 = f21 * f21 * c[0] + 2.0 * f21 * f22 * c[2] + f22 * f22 * c[1]
    b12 = f11 * f21 * c[0] + (f11 * f22 + f12 * f21) * c[2] + f12 * f22 * c[1]
    return b11, b22, b12, f33 * f33 * c[3]


@kernel
def mean_dilatation(displacement, nodes, gradients, hoops, volumes):  # type: ignore[no-untyped-def]
    """Deformed over undeformed volume of one element; not positive if it is turned inside out anywhere."""
    total, undeformed, smallest = 0.0, 0.0, 1.0
    for g in range(4):
        f11, f12, f21, f22, f33 = deformation(displacement, nodes, gradients[g], hoops[g])
        jacobian = (f11 * f22 - f12 * f21) * f33
        smallest = min(smallest, jacobian, f33)
        total += jacobian * volumes[g]
        undeformed += volumes[g]
    if smallest <= 0.0:
        return -1.0, undeformed
    return total / undeformed, undeformed


@kernel
def element(displacement, nodes, gradients, hoops, volumes, history, moduli, force, stiffness, tangent, b_matrix, spread):  # type: ignore[no-untyped-def]
    """Nodal forces (8) and tangent stiffness (8 x 8) of one element; returns False if it is turned inside out.

    moduli: bulk, shear, yield stress (infinite: elastic). `tangent` (5 x 5), `b_matrix` (5 x 8) and `spread` (2 x 8) are work space.
    Written as one loop over Gauss points because the parts share everything they compute.
    """
    bulk, shear, yield_stress = moduli
    dilatation, undeformed = mean_dilatation(displacement, nodes, gradients, hoops, volumes)
    if dilatation <= 0.0:
        return False
    mean_stress, slope = pressure(bulk, dilatation)
    force[:] = 0.0
    stiffness[:, :] = 0.0
    spread[:, :] = 0.0  # row 0: derivative of the deformed volume; row 1: of the nodal forces with the yield limit's J
    for g in range(4):
        f = deformation(displacement, nodes, gradients[g], hoops[g])
        f11, f12, f21, f22, f33 = f
        in_plane = f11 * f22 - f12 * f21
        jacobian = in_plane * f33
        b11, b22, b12, b33 = trial_elastic(f, history[g])
        b1, b2, c, s = principal(b11, b22, b12)
        s1, s2, s3, ratio, _ = radial_return(0.5 * math.log(b1), 0.5 * math.log(b2), 0.5 * math.log(b33), shear, dilatation * yield_stress)
        volume = volumes[g]
        principal_tangent(tangent, b1, b2, s1, s2, s3, ratio, shear, mean_stress * jacobian)
        for i in range(4):
            # spatial gradient of the shape function, then in the principal axes
            gr = (f22 * gradients[g, i, 0] - f21 * gradients[g, i, 1]) / in_plane
            gz = (-f12 * gradients[g, i, 0] + f11 * gradients[g, i, 1]) / in_plane
            g1, g2 = c * gr + s * gz, -s * gr + c * gz
            r, z = 2 * i, 2 * i + 1
            b_matrix[0, r], b_matrix[1, r], b_matrix[2, r], b_matrix[3, r] = c * g1, c * g2, -s * g1, -s * g2
            b_matrix[0, z], b_matrix[1, z], b_matrix[2, z], b_matrix[3, z] = s * g1, s * g2, c * g1, c * g2
            b_matrix[4, r], b_matrix[4, z] = hoops[g, i] / f33, 0.0
        limit = 0.0
        if ratio < 1.0:
            limit = volume / dilatation
        for a in range(8):
            deviator = s1 * b_matrix[0, a] + s2 * b_matrix[3, a] + s3 * b_matrix[4, a]
            force[a] += volume * deviator
            spread[0, a] += volume * jacobian * (b_matrix[0, a] + b_matrix[3, a] + b_matrix[4, a])
            spread[1, a] += limit * deviator
        for a in range(8):
            t0 = volume * (tangent[0, 0] * b_matrix[0, a] + tangent[3, 0] * b_matrix[3, a] + tangent[4, 0] * b_matrix[4, a])
            t1 = volume * (tangent[1, 1] * b_matrix[1, a] + tangent[2, 1] * b_matrix[2, a])
            t2 = volume * (tangent[1, 2] * b_matrix[1, a] + tangent[2, 2] * b_matrix[2, a])
            t3 = volume * (tangent[0, 3] * b_matrix[0, a] + tangent[3, 3] * b_matrix[3, a] + tangent[4, 3] * b_matrix[4, a])
            t4 = volume * (tangent[0, 4] * b_matrix[0, a] + tangent[3, 4] * b_matrix[3, a] + tangent[4, 4] * b_matrix[4, a])
            for j in range(8):
                stiffness[a, j] += (
                    t0 * b_matrix[0, j] + t1 * b_matrix[1, j] + t2 * b_matrix[2, j] + t3 * b_matrix[3, j] + t4 * b_matrix[4, j]
                )
    for a in range(8):
        force[a] += mean_stress * spread[0, a]
        row = (slope * spread[0, a] + spread[1, a]) / undeformed
        for j in range(8):
            stiffness[a, j] += row * spread[0, j]
    return True


@kernel
def assemble(displacement, cells, gradients, hoops, volumes, history, moduli, slots, forces, band):  # type: ignore[no-untyped-def]
    """Sum all elements into nodal forces (dofs) and the flat band matrix (entries go to `slots`); False if one is inside out."""
    force, stiffness = np.empty(8), np.empty((8, 8))
    tangent, b_matrix, spread = np.empty((5, 5)), np.zeros((5, 8)), np.empty((2, 8))
    forces[:] = 0.0
    band[:] = 0.0
    for e in range(cells.shape[0]):
        if not element(
            displacement, cells[e], gradients[e], hoops[e], volumes[e], history[e], moduli, force, stiffness, tangent, b_matrix, spread
        ):
            return False
        for a in range(8):
            forces[2 * cells[e, a // 2] + a % 2] += force[a]
            for j in range(8):
                band[slots[e, a, j]] += stiffness[a, j]
    return True


@kernel
def element_forces(displacement, nodes, gradients, hoops, volumes, history, moduli, forces):  # type: ignore[no-untyped-def]
    """Add the nodal forces of one element to `forces` (dofs); False if it is turned inside out."""
    bulk, shear, yield_stress = moduli
    dilatation, _ = mean_dilatation(displacement, nodes, gradients, hoops, volumes)
    if dilatation <= 0.0:
        return False
    mean_stress, _ = pressure(bulk, dilatation)
    for g in range(4):
        f = deformation(displacement, nodes, gradients[g], hoops[g])
        f11, f12, f21, f22, f33 = f
        in_plane = f11 * f22 - f12 * f21
        b11, b22, b12, b33 = trial_elastic(f, history[g])
        b1, b2, c, s = principal(b11, b22, b12)
        s1, s2, s3, _, _ = radial_return(0.5 * math.log(b1), 0.5 * math.log(b2), 0.5 * math.log(b33), shear, dilatation * yield_stress)
        kirchhoff = mean_stress * in_plane * f33
        rr, zz, rz = s1 * c * c + s2 * s * s + kirchhoff, s1 * s * s + s2 * c * c + kirchhoff, (s1 - s2) * c * s
        # first Piola-Kirchhoff stress times volume
        share = volumes[g] / in_plane
        p_rr, p_rz = share * (rr * f22 - rz * f12), share * (rz * f11 - rr * f21)
        p_zr, p_zz = share * (rz * f22 - zz * f12), share * (zz * f11 - rz * f21)
        p_hoop = volumes[g] * (s3 + kirchhoff) / f33
        for i in range(4):
            forces[2 * nodes[i]] += p_rr * gradients[g, i, 0] + p_rz * gradients[g, i, 1] + p_hoop * hoops[g, i]
            forces[2 * nodes[i] + 1] += p_zr * gradients[g, i, 0] + p_zz * gradients[g, i, 1]
    return True


@kernel
def assemble_forces(displacement, cells, gradients, hoops, volumes, history, moduli, forces):  # type: ignore[no-untyped-def]
    """The nodal forces of `assemble` without its stiffness, for a third of the time; False if an element is turned inside out."""
    forces[:] = 0.0
    for e in range(cells.shape[0]):
        if not element_forces(displacement, cells[e], gradients[e], hoops[e], volumes[e], history[e], moduli, forces):
            return False
    return True


@kernel
def advance(displacement, cells, gradients, hoops, volumes, history, moduli, new_history, plastic_strain, new_plastic_strain, stress):  # type: ignore[no-untyped-def]
    """Take the converged state over: new Cp^-1, equivalent plastic strain and Cauchy stress (rr, zz, rz, hoop) at the Gauss points.

    Returns stored energy, energy dissipated in this step, and the largest trial von Mises stress over the yield limit with its place
    (element, Gauss point).
    """
    bulk, shear, yield_stress = moduli
    stored, dissipated, worst, worst_e, worst_g = 0.0, 0.0, 0.0, 0, 0
    for e in range(cells.shape[0]):
        dilatation, undeformed = mean_dilatation(displacement, cells[e], gradients[e], hoops[e], volumes[e])
        mean_stress, _ = pressure(bulk, dilatation)
        stored += undeformed * volumetric_energy(bulk, dilatation)
        for g in range(4):
            f = deformation(displacement, cells[e], gradients[e, g], hoops[e, g])
            f11, f12, f21, f22, f33 = f
            in_plane = f11 * f22 - f12 * f21
            b11, b22, b12, b33 = trial_elastic(f, history[e, g])
            b1, b2, c, s = principal(b11, b22, b12)
            e1, e2, e3 = 0.5 * math.log(b1), 0.5 * math.log(b2), 0.5 * math.log(b33)
            limit = dilatation * yield_stress
            s1, s2, s3, ratio, q = radial_return(e1, e2, e3, shear, limit)
            stored += volumes[e, g] * (s1 * s1 + s2 * s2 + s3 * s3) / (4.0 * shear)
            strain = 0.0
            if ratio < 1.0:
                strain = (q - limit) / (3.0 * shear)
                dissipated += volumes[e, g] * limit * strain
            if q / limit > worst:
                worst, worst_e, worst_g = q / limit, e, g
            new_plastic_strain[e, g] = plastic_strain[e, g] + strain
            mean = (e1 + e2 + e3) / 3.0
            b1, b2, b33 = math.exp(s1 / shear + 2.0 * mean), math.exp(s2 / shear + 2.0 * mean), math.exp(s3 / shear + 2.0 * mean)
            b11, b22, b12 = b1 * c * c + b2 * s * s, b1 * s * s + b2 * c * c, (b1 - b2) * c * s
            # Cp^-1 = F^-1 b F^-T
            new_history[e, g, 0] = (f22 * f22 * b11 - 2.0 * f22 * f12 * b12 + f12 * f12 * b22) / in_plane**2
            new_history[e, g, 1] = (f21 * f21 * b11 - 2.0 * f21 * f11 * b12 + f11 * f11 * b22) / in_plane**2
            new_history[e, g, 2] = (-f22 * f21 * b11 + (f22 * f11 + f12 * f21) * b12 - f12 * f11 * b22) / in_plane**2
            new_history[e, g, 3] = b33 / f33**2
            stress[e, g, 0] = (s1 * c * c + s2 * s * s) / dilatation + mean_stress
            stress[e, g, 1] = (s1 * s * s + s2 * c * c) / dilatation + mean_stress
            stress[e, g, 2] = (s1 - s2) * c * s / dilatation
            stress[e, g, 3] = s3 / dilatation + mean_stress
    return stored, dissipated, worst, worst_e, worst_g
