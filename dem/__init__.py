"""The discrete element method, small but right: scenes of spheres on the laws of `contactlaws`."""

from dem import impact, output, packing
from dem.box import Box
from dem.particles import Particles, spheres
from dem.scene import Contact, Scene, Stage, packed_scene, uniaxial_compression
from dem.simulation import run
from dem.trajectory import Trajectory

__all__ = [
    "Box",
    "Contact",
    "Particles",
    "Scene",
    "Stage",
    "Trajectory",
    "impact",
    "output",
    "packed_scene",
    "packing",
    "run",
    "spheres",
    "uniaxial_compression",
]
