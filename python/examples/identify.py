"""A drive's parameters from its recordings, and how far they fit: identify.py FOLDER-OF-HYDROLEK"""
import sys

import lacuna
import numpy as np

scenario = lacuna.Scenario(sys.argv[1] + "/joint_2_table1.yaml")
fit = lacuna.identify(scenario, optimizer="lsq", seed=1)["engines"][0]
for name, found in fit["parameters"].items():
    low, high = found["ci95"]
    print(f"{name:24} {found['value']:10.4g} {found['unit']:10} ({low:.4g} to {high:.4g})"
          + ("" if found["identifiable"] else "  not determined by these data"))


def rms(values):
    run = lacuna.simulate(scenario, values, recording="joint_2_table1/test.csv")
    return np.sqrt(np.nanmean((run["channels"]["joint_2.position"] - run["measured"]["joint_2.position"]) ** 2))


known = {p["name"] for p in scenario.parameters}
before, after = rms({}), rms({name: found["value"] for name, found in fit["parameters"].items() if name in known})
print(f"error on the test recording: {before:.4f} rad before, {after:.4f} rad after")
assert after < 0.1 * before
