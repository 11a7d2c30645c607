"""The entry as a whole: few particles, restarts to the last bit, both ways of running, what it says and what it refuses."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import dem
from contactlaws.elastic import Hertz
from contactlaws.elastoplastic import Thornton
from contactlaws.errors import InputError
from contactlaws.tangential import Rolling
from dem.packing import Packing
from dem.trajectory import Trajectory

RADIUS, DENSITY = 5e-6, 4750.0
EDGE = 20.0 * RADIUS


def small_scene(packing: Packing, law: object) -> dem.Scene:
    return dem.packed_scene(packing, DENSITY, dem.Contact(law), dem.uniaxial_compression(0.02), inertial_number=5e-3, outputs=10, frames=2)


def assert_same(one: Trajectory, other: Trajectory) -> None:
    for name in ("time", "stage", "strain", "stress", "coordination_number", "coordination_number_held", "rattlers", "packing_fraction"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for a, b in zip([*one.energies, *one.frames], [*other.energies, *other.frames], strict=True):
        for x, y in zip(np.atleast_1d(a), np.atleast_1d(b), strict=True) if isinstance(a, np.ndarray) else zip(a, b, strict=True):
            if isinstance(x, tuple):
                for p, q in zip(x, y, strict=True):
                    np.testing.assert_array_equal(p, q)
            else:
                np.testing.assert_array_equal(x, y)


class Killed(Exception):
    """Stands for a kill between two outputs."""


@pytest.mark.compiled_only(reason="eight runs; the same arrays go to disk either way")
@pytest.mark.parametrize("law_name", ["hertz", "soft_plastic"])
def test_a_killed_run_goes_on_to_the_same_bits(
    law_name: str, shaken_crystal: Packing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.setattr("dem.simulation.CHECKPOINT_EVERY", 0.0)
    scene, path = small_scene(shaken_crystal, request.getfixturevalue(law_name)), tmp_path / "state.npz"

    def kill(fraction: float, text: str) -> None:
        if fraction > 0.6:
            raise Killed

    with pytest.raises(Killed):
        dem.run(scene, kill, path)
    said: list[str] = []
    resumed = dem.run(scene, lambda fraction, text: said.append(text), path)
    assert any(text.startswith("going on from") for text in said)
    assert_same(resumed, dem.run(scene))
    assert_same(dem.run(scene, None, path), resumed)  # finished: read back
    assert sorted(tmp_path.iterdir()) == [path]  # nothing left behind


def test_a_checkpoint_of_another_scene_or_a_damaged_one_is_refused(hertz: Hertz, shaken_crystal: Packing, tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    scene = small_scene(shaken_crystal, hertz)
    dem.run(scene, None, path)
    with pytest.raises(InputError, match=r"checkpoint scene.*delete"):
        dem.run(dataclasses.replace(scene, outputs=11), None, path)
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(InputError, match="cannot be read"):
        dem.run(scene, None, path)


def test_no_particles(hertz: Hertz) -> None:
    scene = dem.Scene(dem.spheres([], RADIUS, DENSITY), dem.Box((EDGE,) * 3), dem.Contact(hertz), (dem.Stage((0.5, 1.0, 1.0), 1e-6),))
    trajectory = dem.run(scene)
    assert not np.any(trajectory.stress)
    assert len(trajectory.frames[0].position) == 0
    assert trajectory.packing_fraction[-1] == 0.0


def test_one_particle_at_rest_stays(hertz: Hertz) -> None:
    bodies, box = dem.spheres([[RADIUS] * 3], RADIUS, DENSITY), dem.Box((EDGE,) * 3, (True, False, True))
    scene = dem.Scene(bodies, box, dem.Contact(hertz), (dem.Stage((1.0, 1.0, 1.0), 1e-6),))
    np.testing.assert_array_equal(dem.run(scene).frames[-1].position, [[RADIUS] * 3])


def test_two_particles_bounce_through_the_face_of_the_box(hertz: Hertz) -> None:
    near = 1.01 * RADIUS
    bodies = dem.spheres([[near, 0.0, 0.0], [EDGE - near, 0.0, 0.0]], RADIUS, DENSITY, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    scene = dem.Scene(bodies, dem.Box((EDGE,) * 3), dem.Contact(hertz), (dem.Stage((1.0, 1.0, 1.0), 1.5e-7),), time_step_fraction=0.02)
    velocity = dem.run(scene).frames[-1].velocity
    np.testing.assert_allclose(velocity, -bodies.velocity, atol=4e-4)  # the error of a collision is the square of the step's fraction


@pytest.mark.compiled_only(reason="it compares with the interpreted run itself")
def test_compiled_equals_interpreted(soft_plastic: Thornton, shaken_crystal: Packing) -> None:
    """The same operations in the same order; what the compiler may fuse or reorder is round-off, amplified by collisions."""
    scene = small_scene(shaken_crystal._replace(position=shaken_crystal.position[:8]), soft_plastic)
    scene = dataclasses.replace(scene, programme=(dem.Stage((0.9, 0.9, 0.9), 2e-7),), outputs=4, box=dem.Box((4.2 * RADIUS,) * 3))
    script = f"""
import json, numpy as np, dem
from contactlaws.elastoplastic import Thornton
bodies = dem.spheres({(scene.particles.position).tolist()}, {RADIUS}, {DENSITY})
scene = dem.Scene(bodies, dem.Box({scene.box.lengths}), dem.Contact(Thornton(*{tuple(soft_plastic)})), (dem.Stage((0.9, 0.9, 0.9), 2e-7),),
                  outputs=4, frames=2, inertial_number=5e-3)
print(json.dumps(dem.run(scene).stress.tolist()))
"""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    stress = dem.run(scene).stress
    assert stress[-1].max() > 0.0
    np.testing.assert_allclose(np.array(json.loads(done.stdout)), stress, rtol=1e-9, atol=1e-9 * stress.max())


def test_a_run_says_what_it_left_out_and_what_it_was(hertz: Hertz, shaken_crystal: Packing) -> None:
    said: list[tuple[float, str]] = []
    trajectory = dem.run(small_scene(shaken_crystal, hertz), lambda fraction, text: said.append((fraction, text)))
    start = "\n".join(text for fraction, text in said if fraction == 0.0)
    for words in ("no rotations", "one radius", "no memory", "no walls", "affinely", "of the critical"):
        assert words in start
    assert said[-1][0] == 1.0
    statistics = json.loads(json.dumps(trajectory.statistics))
    assert statistics["law_source"] == "Hertz 1882"
    assert statistics["steps"] > 0
    assert max(statistics["dt_over_critical"]) <= 0.4
    assert len(trajectory.time) == 21
    np.testing.assert_allclose(trajectory.strain[[0, 10, 20], 2], [0.0, 0.02, 0.0], atol=1e-12)
    np.testing.assert_array_equal(trajectory.frames[-1].id, np.arange(1, 33))


def test_warnings_name_number_and_depth_of_what_left_the_range(hertz: Hertz, shaken_crystal: Packing) -> None:
    scene = small_scene(shaken_crystal, hertz)
    within = dataclasses.replace(scene, contact=dem.Contact(hertz, fitted_overlap=0.1))
    beyond = dataclasses.replace(scene, contact=dem.Contact(hertz, fitted_overlap=1e-4))
    assert not any("range" in text for text in dem.run(within).warnings)
    assert any("left the range the law was fitted for" in text and "largest D" in text for text in dem.run(beyond).warnings)


def test_too_large_a_step_is_noticed(hertz: Hertz, shaken_crystal: Packing) -> None:
    scene = dataclasses.replace(small_scene(shaken_crystal, hertz), time_step_fraction=1.0, inertial_number=1.0)
    assert any("inertial number" in text for text in dem.run(scene).warnings)


BAD = {
    "tangential": {"contact": dem.Contact(Hertz(RADIUS, 1e11), tangential="mindlin")},  # type: ignore[arg-type]
    "damping": {"contact": dem.Contact(Hertz(RADIUS, 1e11), damping=0.1)},  # type: ignore[arg-type]
    "needs friction": {"contact": dem.Contact(Hertz(RADIUS, 1e11), rolling=Rolling(0.1))},
    "share": {"contact": dem.Contact(Hertz(RADIUS, 1e11), share=0.0)},
    "no wall there": {"walls": (True, False, False)},
    "density_scaling": {"density_scaling": 0.0},
    "moving_walls": {"moving_walls": 2.0},
    "carry": {"carry": ("everything",)},
    "threads": {"threads": 0},
    "compression is positive": {"programme": (dem.confined(-1.0),)},
    "carries the particles along": {"programme": (dem.simple_shear(0.1),), "affine": False},
    "is no registered law": {"contact": dem.Contact("hertz")},
    "finite float": {"contact": dem.Contact(Hertz(RADIUS, math.nan))},
    "must be positive": {"contact": dem.Contact(Hertz(-RADIUS, 1e11))},
    "box length y": {"box": dem.Box((EDGE, 0.0, EDGE))},
    "stretch z": {"programme": dem.uniaxial_compression(1.5)},
    "open axis": {"box": dem.Box((EDGE, EDGE, EDGE), (True, True, False))},
    "duration": {"programme": dem.uniaxial_compression(0.01, strain_rate=0.0)},
    "nothing moves": {"programme": (dem.Stage((1.0, 1.0, 1.0)),)},
    "at least one stage": {"programme": ()},
    "time_step_fraction": {"time_step_fraction": 2.0},
    "inertial_number": {"inertial_number": -1.0},
    "drag": {"drag": 0.0},
    "skin": {"skin": 0.0},
    "outputs": {"outputs": 0},
}


@pytest.mark.parametrize("words", BAD)
def test_bad_scenes_are_refused(words: str, hertz: Hertz) -> None:
    bodies = dem.spheres([[0.0, 0.0, 0.0], [3.0 * RADIUS, 0.0, 0.0]], RADIUS, DENSITY)
    scene = dem.Scene(bodies, dem.Box((EDGE,) * 3), dem.Contact(hertz), dem.uniaxial_compression(0.01))
    with pytest.raises(InputError, match=words):
        dem.run(dataclasses.replace(scene, **BAD[words]))


def test_spheres_inside_each_other_are_refused(hertz: Hertz) -> None:
    bodies = dem.spheres([[0.0, 0.0, 0.0], [0.5 * RADIUS, 0.0, 0.0]], RADIUS, DENSITY)
    with pytest.raises(InputError, match="deeper"):
        dem.run(dem.Scene(bodies, dem.Box((EDGE,) * 3), dem.Contact(hertz), dem.uniaxial_compression(0.01)))


def test_bad_particles_are_refused_all_at_once() -> None:
    with pytest.raises(InputError) as caught:
        dem.spheres([[0.0, 0.0, math.nan], [0.0, 0.0, 0.0]], [RADIUS, -RADIUS], DENSITY)
    assert {problem.name for problem in caught.value.problems} >= {"position", "radius"}
    with pytest.raises(InputError, match="density"):
        dem.spheres([[0.0, 0.0, 0.0]], RADIUS, 0.0)
    with pytest.raises(InputError, match="velocity"):
        dem.spheres([[0.0, 0.0, 0.0]], RADIUS, DENSITY, [[0.0] * 3] * 2)


def test_a_checkpoint_that_cannot_be_written_is_refused_before_computing(hertz: Hertz, shaken_crystal: Packing, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        dem.run(small_scene(shaken_crystal, hertz), None, tmp_path / "nowhere" / "state.npz")
