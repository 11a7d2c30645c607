"""The discrete element method, small but right: scenes of spheres or ellipsoids on the laws of `contactlaws`."""

from dem import impact, output, packing
from dem.box import Box
from dem.particles import Particles, ellipsoids, spheres
from dem.scene import (
    Contact,
    QuasiStatic,
    Scene,
    Stage,
    confined,
    hold,
    isotropic_compression,
    packed_scene,
    simple_shear,
    uniaxial_compression,
)
from dem.simulation import run
from dem.trajectory import Trajectory

__all__ = [
    "Box",
    "Contact",
    "Particles",
    "QuasiStatic",
    "Scene",
    "Stage",
    "Trajectory",
    "confined",
    "ellipsoids",
    "hold",
    "impact",
    "isotropic_compression",
    "output",
    "packed_scene",
    "packing",
    "run",
    "simple_shear",
    "spheres",
    "uniaxial_compression",
]
