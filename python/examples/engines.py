"""Every engine's accelerations of one arm against the default engine's: engines.py FOLDER-OF-HYDROLEK"""
import sys

import lacuna
import numpy as np

STATES = 1000

robot = lacuna.Robot(sys.argv[1] + "/hydrolek.urdf")
random = np.random.default_rng(1)
q = random.uniform(-3.0, 3.0, (STATES, robot.dof))
v = random.uniform(-2.0, 2.0, (STATES, robot.dof))
tau = random.uniform(-20.0, 20.0, (STATES, robot.dof))

reference = lacuna.Dynamics("featherstone", robot).forward_dynamics(q, v, tau)
print(f"{robot.name}, {robot.dof} joints, {STATES} states")
for engine in lacuna.engines():
    if not engine["available"]:
        print(f"{engine['name']:12} {engine['reason']}")
        continue
    a = lacuna.Dynamics(engine["name"], robot).forward_dynamics(q, v, tau)
    apart = np.linalg.norm(a - reference, axis=1) / np.linalg.norm(reference, axis=1)
    print(f"{engine['name']:12} {engine['version']:8} differs by at most {apart.max():.1e}")
    assert apart.max() < 1e-9
