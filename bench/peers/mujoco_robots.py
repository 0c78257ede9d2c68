"""The robots of the simulation benchmarks, stepped by MuJoCo: `mujoco_robots.py FOLDER` writes mujoco.csv there, a row a
run, with the rigid reference among them. bench/README.md describes the columns."""

import csv
import math
import sys
import time
from pathlib import Path

import mujoco
import numpy

GRAVITY = 9.81
SIDE = 5
# A run that would take longer than this is left out, s.
PATIENCE = 8.0
STEPS = [1 / 30, 1 / 60, 1 / 120, 1 / 240, 1 / 480, 1e-3, 5e-4]
# Of order four, and so fine that a coarser one does not matter: the first is the reference.
REFERENCE = [1e-4, 2e-4]
INTEGRATORS = {
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
}


def links():
    """The bodies of a robot: parent, mass, moments, centre, joint."""
    path = Path(__file__).parent.parent / "scenes/ben.csv"
    rows = [line for line in path.read_text().splitlines() if line[0] in "-0123456789"]
    numbers = [[float(x) for x in row.split(",")] for row in rows]
    return [(int(n[0]), n[1], n[2:5], numpy.array(n[5:8]), numpy.array(n[8:11])) for n in numbers]


def model(robots, integrator, h):
    """Robots as trees of ball joints; a body's frame is that of the robot, moved to its joint."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, 0, -GRAVITY]
    spec.option.timestep = h
    spec.option.integrator = integrator
    spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    for robot in range(robots):
        at = numpy.array([3.0 * (robot % SIDE), 3.0 * (robot // SIDE), 0.0])
        bodies = []
        for parent, mass, moments, centre, joint in links():
            above = spec.worldbody if parent < 0 else bodies[parent]
            origin = joint + at if parent < 0 else joint - links()[parent][4]
            body = above.add_body(pos=origin, mass=mass, inertia=moments, ipos=centre - joint, explicitinertial=True)
            body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL)
            bodies.append(body)
    return spec.compile()


def torques(times):
    """For each time, the torque on every body of a robot."""
    bodies = links()
    result = numpy.zeros((len(times), len(bodies), 3))
    for k, (parent, mass, *_) in enumerate(bodies):
        if parent >= 0:
            size = 0.3 * mass * GRAVITY * 0.15 * numpy.sin(2 * math.pi * (0.5 + 0.05 * k) * times + k)
            result[:, k, k % 2] += size
            result[:, parent, k % 2] -= size
    return result


def run(robots, integrator, driven, h):
    """Seconds, positions of the first robot's bodies, largest change of a robot's energy; none if it takes too long."""
    m = model(robots, integrator, h)
    d = mujoco.MjData(m)
    count = len(links())
    steps = round((1.0 if driven else 10.0) / h)
    if not driven:
        # Of each robot's joints only that at the pin turns.
        d.qvel[:] = numpy.tile(numpy.concatenate([[2.0, 1.0, 0.0], numpy.zeros(3 * count - 3)]), robots)
    mujoco.mj_forward(m, d)
    start, drift, spent = d.energy.sum(), 0.0, 0.0
    # What drives is sampled in the middle of steps, and known before the clock starts.
    loads = torques((numpy.arange(steps) + 0.5) * h) if driven else None
    for k in range(steps):
        clock = time.thread_time()
        if driven:
            d.xfrc_applied[1:, 3:].reshape(robots, count, 3)[:] = loads[k]
        mujoco.mj_step(m, d)
        spent += time.thread_time() - clock
        if not driven:
            # The energy that a step leaves behind is that of its start.
            drift = max(drift, abs(d.energy.sum() - start))
        if k == steps // 50 and spent * steps > PATIENCE * (k + 1):
            return None
    mujoco.mj_forward(m, d)
    drift = max(drift, abs(d.energy.sum() - start))
    if any(warning.number for warning in d.warning):
        # It is unstable, and began anew in the middle of the run.
        d.xipos[:], drift = math.nan, math.nan
    return spent, d.xipos[1 : count + 1].ravel().tolist(), drift / robots


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "mujoco.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["engine", "version", "setting", "scene", "h", "us", "drift", "positions"])

        def row(setting, integrator, scene, h, robots):
            driven = scene == "ben25"
            # The least of three is what a quiet machine takes.
            ends = [run(robots, integrator, driven, h) for _ in range(3 if driven and robots > 1 else 1)]
            if None in ends:
                return
            least = min(end[0] for end in ends) / round((1.0 if driven else 10.0) / h) * 1e6
            _, positions, drift = ends[-1]
            drift, positions = ("", " ".join(map(str, positions))) if driven else (drift, "")
            writer.writerow(["MuJoCo", mujoco.__version__, setting, scene, h, least, drift, positions])
            print(f"MuJoCo, {setting}, {scene}, h {h:.2e}: {least:.0f} µs a step {drift}", flush=True)

        for h in REFERENCE:
            row("reference", INTEGRATORS["RK4"], "ben25", h, 1)
        for setting, integrator in INTEGRATORS.items():
            for h in STEPS:
                for scene in ["ben25", "ben25-free"]:
                    row(setting, integrator, scene, h, SIDE * SIDE)


main()
