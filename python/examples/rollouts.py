"""What is not known of a drive, as a band around the motion that it predicts: rollouts.py FOLDER-OF-HYDROLEK"""
import sys

import lacuna
import numpy as np

SETS = 256
UNSURE = 0.1  # relative standard deviation

scenario = lacuna.Scenario(sys.argv[1] + "/joint_2_table1.yaml")
simulator = lacuna.Simulator(scenario, names=["joint_2.gain", "joint_2.damping", "joint_2.stiffness"])
random = np.random.default_rng(1)
sets = simulator.values * np.exp(UNSURE * random.standard_normal((SETS, len(simulator.names))))
motions = simulator.rollouts(sets)[:, :, 0]  # (SETS, samples), rad

low, high = np.percentile(motions, [2.5, 97.5], axis=0)
measured = simulator.measured[:, 0]
inside = np.mean((measured >= low) & (measured <= high))
print(f"{SETS} simulations of {simulator.recording}, {simulator.time[-1] - simulator.time[0]:.1f} s each")
print(f"{simulator.channels[0]}: the band is {np.mean(high - low):.3f} rad wide, {100 * inside:.0f} % of what was "
      "measured lies in it")
assert np.isfinite(motions).all() and 0.0 < inside < 1.0
