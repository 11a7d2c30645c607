"""The compiled element: four-node axisymmetric quadrilateral with element-wise mean dilatation (Q1/P0), finite strain.

The deviator depends on the displacement at the four Gauss points, the pressure on the mean dilatation J of the element (integral of det F
over its undeformed volume), and the yield limit on both (Cauchy yield: q of the Kirchhoff deviator <= J Y). The tangent is the exact
derivative; the derivative of the yield limit with J makes it unsymmetric.
"""

from __future__ import annotations

import math

import numpy as np

from contactlaws.compiled import kernel
from fem.stress import hencky_deviator, inlined, norm_squared, pressure, radial_return, sinh_over, tangent, volumetric_energy


@inlined
def deform(displacement, cells, gradients, hoops, volumes, e, stretch):  # type: ignore[no-untyped-def]
    """Fill `stretch` (4, 5) with the deformation gradients (rr, rz, zr, zz, hoop) at the Gauss points of element `e`.

    Returns its deformed over its undeformed volume, which is not positive if it is turned inside out anywhere, and the undeformed one.
    """
    total, undeformed, smallest = 0.0, 0.0, 1.0
    for g in range(4):
        f11, f12, f21, f22, f33 = 1.0, 0.0, 0.0, 1.0, 1.0
        for i in range(4):
            node, gr, gz = cells[e, i], gradients[e, g, i, 0], gradients[e, g, i, 1]
            ur, uz = displacement[node, 0], displacement[node, 1]
            f11 += ur * gr
            f12 += ur * gz
            f21 += uz * gr
            f22 += uz * gz
            f33 += ur * hoops[e, g, i]
        stretch[g, 0], stretch[g, 1], stretch[g, 2], stretch[g, 3], stretch[g, 4] = f11, f12, f21, f22, f33
        jacobian = (f11 * f22 - f12 * f21) * f33
        smallest = min(smallest, jacobian, f33)
        total += jacobian * volumes[e, g]
        undeformed += volumes[e, g]
    if smallest <= 0.0:
        return -1.0, undeformed
    return total / undeformed, undeformed


@inlined
def trial_elastic(stretch, history, e, g):  # type: ignore[no-untyped-def]
    """Trial b = F Cp^-1 F^T (rr, zz, rz, hoop) from the deformation gradient and the stored Cp^-1 (rr, zz, rz, hoop)."""
    f11, f12, f21, f22, f33 = stretch[g, 0], stretch[g, 1], stretch[g, 2], stretch[g, 3], stretch[g, 4]
    c11, c22, c12 = history[e, g, 0], history[e, g, 1], history[e, g, 2]
    b11 = f11 * f11 * c11 + 2.0 * f11 * f12 * c12 + f12 * f12 * c22
    b22 = f21 * f21 * c11 + 2.0 * f21 * f22 * c12 + f22 * f22 * c22
    b12 = f11 * f21 * c11 + (f11 * f22 + f12 * f21) * c12 + f12 * f22 * c22
    return b11, b22, b12, f33 * f33 * history[e, g, 3]


#: rows in the work space of an element, a number for each node
GRADIENT_R, GRADIENT_Z, GRADIENT_H = 0, 1, 2  # of the shape functions
R_BY_RR, R_BY_RZ, R_BY_H, R_BY_ZR, R_BY_ZZ, Z_BY_ZR, Z_BY_ZZ = 3, 4, 5, 6, 7, 8, 9  # stresses from a node's displacement along r or z
BLOCK_RR, BLOCK_ZR, BLOCK_ZZ = 10, 14, 18  # of the symmetric part of the stiffness, four rows each
ROWS = 22


@kernel
def work_space():  # type: ignore[no-untyped-def]
    """What `element` writes on: deformation gradients, a tangent, derivatives of volume and flow, rows of the nodes."""
    return np.empty((4, 5)), np.empty((5, 5)), np.empty((2, 8)), np.empty((ROWS, 4))


@inlined
def element(displacement, cells, gradients, hoops, volumes, history, moduli, e, force, stiffness, stretch, entries, spread, rows):  # type: ignore[no-untyped-def]
    """Nodal forces (8) and tangent stiffness (8 x 8) of element `e`; returns False if it is turned inside out.

    moduli: bulk, shear, yield stress (infinite: elastic). The last four are from `work_space`.
    """
    bulk, shear, yield_stress = moduli
    dilatation, undeformed = deform(displacement, cells, gradients, hoops, volumes, e, stretch)
    if dilatation <= 0.0:
        return False
    mean_stress, slope = pressure(bulk, dilatation)
    for i in range(8):
        # spread: derivative of the deformed volume; and of the nodal forces with the yield limit
        force[i] = spread[0, i] = spread[1, i] = 0.0
    for i in range(BLOCK_RR, ROWS):
        for j in range(4):
            rows[i, j] = 0.0
    for g in range(4):
        spatial_gradients(stretch, gradients, hoops, e, g, rows)
        jacobian = (stretch[g, 0] * stretch[g, 3] - stretch[g, 1] * stretch[g, 2]) * stretch[g, 4]
        b11, b22, b12, b33 = trial_elastic(stretch, history, e, g)
        a, h, k = hencky_deviator(b11, b22, b12, b33)
        ratio, _ = radial_return(a, h, k, shear, dilatation * yield_stress)
        add_forces(a, h, k, 2.0 * shear * ratio * volumes[e, g], jacobian * volumes[e, g], ratio < 1.0, rows, force, spread)
        tangent(b11, b22, b12, a, h, k, ratio, shear, mean_stress * jacobian, volumes[e, g], entries)
        add_blocks(entries, rows)
    by_volume, by_limit = slope / undeformed, 1.0 / (dilatation * undeformed)
    for i in range(8):
        force[i] += mean_stress * spread[0, i]
        # the limit J Y grows with J, and the stress on it
        spread[1, i] = by_volume * spread[0, i] + by_limit * spread[1, i]
    for i in range(4):
        for j in range(4):
            stiffness[2 * i, 2 * j] = rows[BLOCK_RR + i, j] + spread[1, 2 * i] * spread[0, 2 * j]
            stiffness[2 * i, 2 * j + 1] = rows[BLOCK_ZR + j, i] + spread[1, 2 * i] * spread[0, 2 * j + 1]
            stiffness[2 * i + 1, 2 * j] = rows[BLOCK_ZR + i, j] + spread[1, 2 * i + 1] * spread[0, 2 * j]
            stiffness[2 * i + 1, 2 * j + 1] = rows[BLOCK_ZZ + i, j] + spread[1, 2 * i + 1] * spread[0, 2 * j + 1]
    return True


@inlined
def spatial_gradients(stretch, gradients, hoops, e, g, rows):  # type: ignore[no-untyped-def]
    """Put the derivatives of the shape functions with the deformed place into `rows`."""
    f11, f12, f21, f22 = stretch[g, 0], stretch[g, 1], stretch[g, 2], stretch[g, 3]
    over, hoop_over = 1.0 / (f11 * f22 - f12 * f21), 1.0 / stretch[g, 4]
    f11, f12, f21, f22 = f11 * over, f12 * over, f21 * over, f22 * over
    for i in range(4):
        gr, gz = gradients[e, g, i, 0], gradients[e, g, i, 1]
        rows[GRADIENT_R, i] = f22 * gr - f21 * gz
        rows[GRADIENT_Z, i] = f11 * gz - f12 * gr
        rows[GRADIENT_H, i] = hoops[e, g, i] * hoop_over


@inlined
def add_forces(a, h, k, stress, deformed, flows, rows, force, spread):  # type: ignore[no-untyped-def]
    """Add to the nodal forces the deviator's, and to `spread` the derivatives of the volume and the forces of points that flow.

    stress: twice the modulus that is left of the shear modulus, times the volume; deformed: the volume now.
    """
    rr, zz, rz, hoop = stress * (a + h), stress * (a - h), stress * k, -2.0 * stress * a
    for i in range(4):
        gr, gz, gh = rows[GRADIENT_R, i], rows[GRADIENT_Z, i], rows[GRADIENT_H, i]
        along_r, along_z = rr * gr + rz * gz + hoop * gh, rz * gr + zz * gz
        force[2 * i] += along_r
        force[2 * i + 1] += along_z
        spread[0, 2 * i] += deformed * (gr + gh)
        spread[0, 2 * i + 1] += deformed * gz
        if flows:
            spread[1, 2 * i] += along_r
            spread[1, 2 * i + 1] += along_z


@inlined
def add_blocks(t, rows):  # type: ignore[no-untyped-def]
    """Add gradient x tangent x gradient of one Gauss point to the blocks of the stiffness: r with r, z with r and z with z.

    t: tangent (5, 5), symmetric: rr, rz, zr, zz, hoop. A displacement along r has the gradients rr, rz and hoop, one along z zr and zz.
    """
    for j in range(4):
        gr, gz, gh = rows[GRADIENT_R, j], rows[GRADIENT_Z, j], rows[GRADIENT_H, j]
        rows[R_BY_RR, j] = t[0, 0] * gr + t[0, 1] * gz + t[0, 4] * gh
        rows[R_BY_RZ, j] = t[1, 0] * gr + t[1, 1] * gz + t[1, 4] * gh
        rows[R_BY_H, j] = t[4, 0] * gr + t[4, 1] * gz + t[4, 4] * gh
        rows[R_BY_ZR, j] = t[2, 0] * gr + t[2, 1] * gz + t[2, 4] * gh
        rows[R_BY_ZZ, j] = t[3, 0] * gr + t[3, 1] * gz + t[3, 4] * gh
        rows[Z_BY_ZR, j] = t[2, 2] * gr + t[2, 3] * gz
        rows[Z_BY_ZZ, j] = t[3, 2] * gr + t[3, 3] * gz
    for i in range(4):
        gr, gz, gh = rows[GRADIENT_R, i], rows[GRADIENT_Z, i], rows[GRADIENT_H, i]
        for j in range(4):
            rows[BLOCK_RR + i, j] += gr * rows[R_BY_RR, j] + gz * rows[R_BY_RZ, j] + gh * rows[R_BY_H, j]
            rows[BLOCK_ZR + i, j] += gr * rows[R_BY_ZR, j] + gz * rows[R_BY_ZZ, j]
            rows[BLOCK_ZZ + i, j] += gr * rows[Z_BY_ZR, j] + gz * rows[Z_BY_ZZ, j]


@kernel
def assemble(displacement, cells, gradients, hoops, volumes, history, moduli, slots, forces, band):  # type: ignore[no-untyped-def]
    """Sum all elements into nodal forces (dofs) and the flat band matrix (entries go to `slots`); False if one is inside out."""
    force, stiffness = np.empty(8), np.empty((8, 8))
    stretch, entries, spread, rows = work_space()
    forces[:] = 0.0
    band[:] = 0.0
    for e in range(cells.shape[0]):
        if not element(
            displacement, cells, gradients, hoops, volumes, history, moduli, e, force, stiffness, stretch, entries, spread, rows
        ):
            return False
        for a in range(8):
            forces[2 * cells[e, a // 2] + a % 2] += force[a]
            for j in range(8):
                band[slots[e, a, j]] += stiffness[a, j]
    return True


@inlined
def element_forces(displacement, cells, gradients, hoops, volumes, history, moduli, e, stretch, forces):  # type: ignore[no-untyped-def]
    """Add the nodal forces of element `e` to `forces` (dofs); False if it is turned inside out. stretch (4, 5): work space."""
    bulk, shear, yield_stress = moduli
    dilatation, _ = deform(displacement, cells, gradients, hoops, volumes, e, stretch)
    if dilatation <= 0.0:
        return False
    mean_stress, _ = pressure(bulk, dilatation)
    for g in range(4):
        f11, f12, f21, f22, f33 = stretch[g, 0], stretch[g, 1], stretch[g, 2], stretch[g, 3], stretch[g, 4]
        b11, b22, b12, b33 = trial_elastic(stretch, history, e, g)
        a, h, k = hencky_deviator(b11, b22, b12, b33)
        ratio, _ = radial_return(a, h, k, shear, dilatation * yield_stress)
        in_plane, modulus = f11 * f22 - f12 * f21, 2.0 * shear * ratio
        kirchhoff = mean_stress * in_plane * f33
        rr, zz, rz = modulus * (a + h) + kirchhoff, modulus * (a - h) + kirchhoff, modulus * k
        # first Piola-Kirchhoff stress times volume
        share = volumes[e, g] / in_plane
        p_rr, p_rz = share * (rr * f22 - rz * f12), share * (rz * f11 - rr * f21)
        p_zr, p_zz = share * (rz * f22 - zz * f12), share * (zz * f11 - rz * f21)
        p_hoop = volumes[e, g] * (kirchhoff - 2.0 * modulus * a) / f33
        for i in range(4):
            node, gr, gz = cells[e, i], gradients[e, g, i, 0], gradients[e, g, i, 1]
            forces[2 * node] += p_rr * gr + p_rz * gz + p_hoop * hoops[e, g, i]
            forces[2 * node + 1] += p_zr * gr + p_zz * gz
    return True


@kernel
def assemble_forces(displacement, cells, gradients, hoops, volumes, history, moduli, forces):  # type: ignore[no-untyped-def]
    """The nodal forces of `assemble` without its stiffness, for a third of the time; False if an element is turned inside out."""
    stretch = np.empty((4, 5))
    forces[:] = 0.0
    for e in range(cells.shape[0]):
        if not element_forces(displacement, cells, gradients, hoops, volumes, history, moduli, e, stretch, forces):
            return False
    return True


@kernel
def advance(displacement, cells, gradients, hoops, volumes, history, moduli, new_history, plastic_strain, new_plastic_strain, stress):  # type: ignore[no-untyped-def]
    """Take the converged state over: new Cp^-1, equivalent plastic strain and Cauchy stress (rr, zz, rz, hoop) at the Gauss points.

    Returns stored energy, energy dissipated in this step, and the largest trial von Mises stress over the yield limit with its place
    (element, Gauss point).
    """
    bulk, shear, yield_stress = moduli
    stretch = np.empty((4, 5))
    stored, dissipated, worst, worst_e, worst_g = 0.0, 0.0, 0.0, 0, 0
    for e in range(cells.shape[0]):
        dilatation, undeformed = deform(displacement, cells, gradients, hoops, volumes, e, stretch)
        mean_stress, _ = pressure(bulk, dilatation)
        stored += undeformed * volumetric_energy(bulk, dilatation)
        limit = dilatation * yield_stress
        per_limit = 1.0 / (limit * limit)
        for g in range(4):
            b11, b22, b12, b33 = trial_elastic(stretch, history, e, g)
            a, h, k = hencky_deviator(b11, b22, b12, b33)
            ratio, square = radial_return(a, h, k, shear, limit)
            stored += volumes[e, g] * shear * ratio * ratio * norm_squared(a, h, k)
            if square * per_limit > worst:
                worst, worst_e, worst_g = square * per_limit, e, g
            before, a, h, k = a, ratio * a, ratio * h, ratio * k
            new_plastic_strain[e, g] = plastic_strain[e, g]
            for i in range(4):
                new_history[e, g, i] = history[e, g, i]
            if ratio < 1.0:
                strain = (math.sqrt(square) - limit) / (3.0 * shear)
                dissipated += volumes[e, g] * limit * strain
                new_plastic_strain[e, g] += strain
                flow(stretch, b11 * b22 - b12 * b12, b33, a - before, h, k, e, g, new_history)
            modulus = 2.0 * shear / dilatation
            stress[e, g, 0] = modulus * (a + h) + mean_stress
            stress[e, g, 1] = modulus * (a - h) + mean_stress
            stress[e, g, 2] = modulus * k
            stress[e, g, 3] = -2.0 * modulus * a + mean_stress
    return stored, dissipated, math.sqrt(worst), worst_e, worst_g


@inlined
def flow(stretch, determinant, hoop, da, h, k, e, g, history):  # type: ignore[no-untyped-def]
    """Put Cp^-1 = F^-1 b F^-T of point `g` of element `e` into `history` after plastic flow.

    determinant: of the in-plane part of the trial b; hoop: its hoop component; da: by how much the flow changed a of its Hencky strain;
    h, k: deviator in the plane after it.
    """
    change, square = math.exp(2.0 * da), 4.0 * (h * h + k * k)
    mean = math.sqrt(determinant) * change
    part = sinh_over(square)
    half, b12, mean = 2.0 * mean * part * h, 2.0 * mean * part * k, mean * math.sqrt(1.0 + square * part * part)
    b11, b22, b33 = mean + half, mean - half, hoop / (change * change)
    f11, f12, f21, f22, f33 = stretch[g, 0], stretch[g, 1], stretch[g, 2], stretch[g, 3], stretch[g, 4]
    over = 1.0 / (f11 * f22 - f12 * f21)
    f11, f12, f21, f22 = f11 * over, f12 * over, f21 * over, f22 * over
    history[e, g, 0] = f22 * f22 * b11 - 2.0 * f22 * f12 * b12 + f12 * f12 * b22
    history[e, g, 1] = f21 * f21 * b11 - 2.0 * f21 * f11 * b12 + f11 * f11 * b22
    history[e, g, 2] = -f22 * f21 * b11 + (f22 * f11 + f12 * f21) * b12 - f12 * f11 * b22
    history[e, g, 3] = b33 / (f33 * f33)
