"""One arm before and after its damper was changed, and what two sets of recordings tell of it: diff.py [ANYTHING]

The arm, its recordings and its scenario are made here, in a temporary folder.
"""
import tempfile
from pathlib import Path

import lacuna
import numpy as np

NOISE = 3e-4  # rad
ROBOT = """<robot name='arm'><link name='base'/>
  <link name='arm'><inertial><origin xyz='0.4 0 0'/><mass value='2'/>
  <inertia ixx='0.01' ixy='0' ixz='0' iyy='0.2' iyz='0' izz='0.2'/></inertial></link>
  <joint name='elbow' type='continuous'><parent link='base'/><child link='arm'/><axis xyz='0 1 0'/></joint></robot>"""
SCENARIO = """format: lacuna-scenario/1
name: arm
robot: arm.urdf
actuators:
  elbow: {model: torque_source, gain: 20, damping: 2, stiffness: 40, rest: 0.3}
identify:
  gain: {relative_bounds: [0.25, 4]}
  damping: {relative_bounds: [0.25, 4]}
  stiffness: {relative_bounds: [0.25, 4]}
channels:
  time: t
  command: {elbow: u}
  position: {elbow: q}
noise: {position: 3e-4}
recordings:
  - {file: train.csv, role: train}
  - {file: validate.csv, role: validate}
"""


def recorded(folder, values, seed):
    """The arm's scenario in `folder`, its recordings simulated with other values and read with noise."""
    folder.mkdir()
    (folder / "arm.urdf").write_text(ROBOT)
    (folder / "scenario.yaml").write_text(SCENARIO)
    time = np.arange(0.0, 8.0, 0.02)
    random = np.random.default_rng(seed)

    def write(name, u, q):
        np.savetxt(folder / name, np.column_stack([time, u, q]), delimiter=",", header="t,u,q", comments="", fmt="%.17g")

    names = ["train.csv", "validate.csv"]
    commands = [np.sin(2.1 * time + phase) + 0.6 * np.sin(5.3 * time) for phase in (0.0, 1.0)]
    for name, u in zip(names, commands):
        write(name, u, np.zeros_like(time))
    still = lacuna.Scenario(folder / "scenario.yaml")
    for name, u in zip(names, commands):
        motion = lacuna.simulate(still, values, recording=name)
        write(name, u, motion["channels"]["elbow.position"] + NOISE * random.standard_normal(len(time)))
    return lacuna.Scenario(folder / "scenario.yaml")


with tempfile.TemporaryDirectory() as folder:
    before = recorded(Path(folder, "before"), {"elbow.gain": 25.0, "elbow.damping": 2.4}, 1)
    after = recorded(Path(folder, "after"), {"elbow.gain": 25.0, "elbow.damping": 2.9}, 2)
    found = lacuna.diff(before, after, population=20, generations=5)

print(found["verdict"])
for change in found["changes"]:
    b, a = change["b"], change["a"]
    print(f"{change['name']}: {a['value']:.3f} -> {b['value']:.3f} {change['unit']}, "
          f"95 % of the second: {b['ci95'][0]:.3f} to {b['ci95'][1]:.3f}, probability {change['probability']:.2f}")
assert [change["name"] for change in found["changes"]] == ["elbow.damping"]
assert isinstance(found["changes"][0]["b"]["ci95"], np.ndarray)
assert np.all(np.abs(found["changes"][0]["b"]["value"] - 2.9) < 0.1)
