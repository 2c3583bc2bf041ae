"""The Python module as its users call it: lacuna_test.py FOLDER-OF-SCENARIOS"""
import os
import signal
import sys
import tempfile
import threading
import time
import unittest

import lacuna
import numpy as np

SCENARIOS = sys.argv.pop(1)
AVAILABLE = [engine["name"] for engine in lacuna.engines() if engine["available"]]
# Of a motion of about a radian over 20 s: rounding, spread by the motion; ODE's own error is rounding only, too, times
# the condition of its constraints (backends/ode).
SAME_MOTION = 1e-9

LENGTH, MASS, INERTIA, GRAVITY = 0.7, 1.3, 0.05, 9.81
PENDULUM = f"""<robot name='pendulum'><link name='world_link'/>
  <link name='bob'><inertial><origin xyz='0 0 {-LENGTH}'/><mass value='{MASS}'/>
  <inertia ixx='{INERTIA}' iyy='{INERTIA}' izz='{INERTIA}' ixy='0' ixz='0' iyz='0'/></inertial></link>
  <joint name='swing' type='continuous'><parent link='world_link'/><child link='bob'/><axis xyz='0 1 0'/></joint>
</robot>"""


def pendulum():
    with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
        file.write(PENDULUM)
        file.flush()
        return lacuna.Robot(file.name)


def joint_2():
    return lacuna.Scenario(os.path.join(SCENARIOS, "hydrolek", "joint_2_table1.yaml"))


MJCF = f"""<mujoco model='pendulum'><worldbody><body name='bob'><joint name='swing' axis='0 1 0'/>
  <inertial pos='0 0 {-LENGTH}' mass='{MASS}' diaginertia='{INERTIA} {INERTIA} {INERTIA}'/></body></worldbody></mujoco>"""


class Robots(unittest.TestCase):
    def test_are_the_same_from_mjcf_and_urdf(self):
        with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
            file.write(MJCF)
            file.flush()
            robot = lacuna.Robot(file.name)
        self.assertEqual((robot.dof, robot.joints[0]["name"], robot.moving_mass), (1, "swing", MASS))
        q, v, tau = np.random.default_rng(2).uniform(-2.0, 2.0, (3, 20, 1))
        # The same numbers by another reader: equal but for the inertia's rotation into the body's frame.
        np.testing.assert_allclose(lacuna.Dynamics("featherstone", robot).forward_dynamics(q, v, tau),
                                   lacuna.Dynamics("featherstone", pendulum()).forward_dynamics(q, v, tau), rtol=1e-13)

    def test_of_a_xacro_file_the_command_to_run_is_said(self):
        with tempfile.NamedTemporaryFile("w", suffix=".xacro") as file:
            file.write(PENDULUM)
            file.flush()
            with self.assertRaisesRegex(lacuna.InputError, "xacro .* > robot.urdf"):
                lacuna.Robot(file.name)


class Engines(unittest.TestCase):
    def test_say_what_they_are_or_why_they_are_missing(self):
        self.assertEqual(lacuna.engines()[0]["name"], "featherstone")
        for engine in lacuna.engines():
            self.assertTrue(engine["version"] if engine["available"] else engine["reason"], engine)

    def test_give_the_pendulums_closed_form_for_many_states(self):
        q, v, tau = np.random.default_rng(1).uniform(-2.0, 2.0, (3, 50, 1))
        exact = (tau - MASS * GRAVITY * LENGTH * np.sin(q)) / (INERTIA + MASS * LENGTH**2)
        for name in AVAILABLE:
            dynamics = lacuna.Dynamics(name, pendulum())
            a = dynamics.forward_dynamics(q, v, tau)
            self.assertEqual(a.shape, (50, 1))
            np.testing.assert_allclose(a, exact, rtol=1e-9, atol=1e-9, err_msg=name)
            np.testing.assert_allclose(dynamics.inverse_dynamics(q, v, a), tau, atol=1e-9, err_msg=name)
            np.testing.assert_array_equal(dynamics.forward_dynamics(q[3], v[3], tau[3]), a[3])

    def test_give_mass_matrix_energy_and_poses(self):
        for name in AVAILABLE:
            dynamics = lacuna.Dynamics(name, pendulum())
            about_axis = INERTIA + MASS * LENGTH**2
            np.testing.assert_allclose(dynamics.mass_matrix([0.3]), [[about_axis]], rtol=1e-9)
            energy = dynamics.energy([0.3], [2.0])
            self.assertAlmostEqual(energy["kinetic"], 0.5 * about_axis * 4.0, 9)
            self.assertAlmostEqual(energy["potential"], -MASS * GRAVITY * LENGTH * np.cos(0.3), 9)
            pose = dynamics.body_poses([0.3])
            self.assertEqual(pose.shape, (1, 4, 4))
            np.testing.assert_allclose(pose[0] @ [0, 0, -LENGTH, 1],
                                       [-LENGTH * np.sin(0.3), 0, -LENGTH * np.cos(0.3), 1], atol=1e-12)

    def test_take_other_masses_and_gravity_and_step_by_themselves(self):
        for engine in lacuna.engines():
            if not engine["available"]:
                continue
            dynamics = lacuna.Dynamics(engine["name"], pendulum())
            dynamics.set_inertial(0, 2 * MASS, [0, 0, -LENGTH], np.eye(3) * 2 * INERTIA)
            dynamics.set_gravity([0, 0, 0])
            a = dynamics.forward_dynamics([0.3], [0.0], [1.0])
            np.testing.assert_allclose(a, 0.5 / (INERTIA + MASS * LENGTH**2), rtol=1e-9)
            step = 1e-3
            q, v = dynamics.step(engine["native_integrators"][0], [0.3], [1.0], [0.0], step)
            # Nothing acts: v stays, but for what a method of first order may leave in a step.
            np.testing.assert_allclose(q, 0.3 + step, atol=step**2, err_msg=engine["name"])
            np.testing.assert_allclose(v, 1.0, atol=step**2, err_msg=engine["name"])

    def test_refuse_what_does_not_fit(self):
        with self.assertRaises(lacuna.InputError) as raised:
            lacuna.Dynamics("imaginary", pendulum())
        self.assertIn("featherstone", str(raised.exception))
        self.assertTrue(issubclass(lacuna.InputError, ValueError) and issubclass(lacuna.WorkError, RuntimeError))
        dynamics = lacuna.Dynamics("featherstone", pendulum())
        for shape in [(2,), (3, 2), (0,), (1, 1, 1)]:
            with self.assertRaises(ValueError):
                dynamics.forward_dynamics(np.zeros(shape), np.zeros(shape), np.zeros(shape))
        with self.assertRaises(ValueError):
            dynamics.forward_dynamics(np.zeros((3, 1)), np.zeros((2, 1)), np.zeros((3, 1)))


class Simulations(unittest.TestCase):
    def test_of_many_sets_are_those_of_each_set(self):
        scenario = joint_2()
        simulator = lacuna.Simulator(scenario, names=["joint_2.gain", "joint_2.damping"])
        sets = simulator.values * np.random.default_rng(1).uniform(0.8, 1.2, (21, 2))
        many = simulator.rollouts(sets)
        self.assertEqual(many.shape, (21, len(simulator.time), 1))
        self.assertEqual(simulator.measured.shape, many.shape[1:])
        for k in (0, 7, 20):
            np.testing.assert_array_equal(simulator.rollouts(sets[k:k + 1])[0], many[k])
            one = lacuna.simulate(scenario, dict(zip(simulator.names, sets[k])), step=simulator.step)
            np.testing.assert_array_equal(one["channels"]["joint_2.position"], many[k, :, 0])
            np.testing.assert_array_equal(one["time"], simulator.time)
        self.assertGreater(np.abs(many[0] - many[7]).max(), 1e-3)  # the sets do differ

    def test_are_the_same_on_every_engine(self):
        scenario = joint_2()
        names = ["joint_2.gain"]
        simulator = lacuna.Simulator(scenario, names=names)
        sets = simulator.values * np.array([[0.9], [1.1]])
        ours = simulator.rollouts(sets)
        for name in AVAILABLE:
            theirs = lacuna.rollouts(scenario, sets, names=names, engine=name, step=simulator.step)
            np.testing.assert_allclose(theirs, ours, atol=SAME_MOTION, err_msg=name)

    def test_refuse_what_does_not_fit(self):
        scenario = joint_2()
        simulator = lacuna.Simulator(scenario, names=["joint_2.damping"])
        for wrong in (np.zeros((2, 2)), np.zeros(2), np.zeros((1, 1, 1))):
            with self.assertRaises(ValueError):
                simulator.rollouts(wrong)
        for value in (-1.0, np.nan, np.inf):
            with self.assertRaises(lacuna.InputError) as raised:
                simulator.rollouts([[value]])
            self.assertIn("joint_2.damping", str(raised.exception))
        for wrong in ({"names": ["no.such"]}, {"recording": "no.csv"}, {"engine": "none"}, {"step": 0.0}):
            with self.assertRaises(lacuna.InputError, msg=wrong):
                lacuna.Simulator(scenario, **wrong)
        with self.assertRaises(lacuna.InputError):
            lacuna.Scenario("/no/such/scenario.yaml")
        self.assertEqual(simulator.rollouts(np.zeros((0, 1))).shape, (0, len(simulator.time), 1))


class Searches(unittest.TestCase):
    def test_identify_the_same_for_the_same_seed(self):
        one, two = (lacuna.identify(joint_2(), population=10, generations=3, seed=5, threads=threads)["engines"][0]
                    for threads in (1, 2))
        self.assertEqual(one["parameters"], two["parameters"])
        noise = 3e-4  # rad, of the bundled recordings
        self.assertLess(one["rms"]["test"]["joint_2"], 1.2 * noise)

    def test_diagnose_what_another_effect_left(self):
        found = lacuna.diagnose(joint_2(), optimizer="lsq", other_engines=False)
        self.assertEqual(found["format"], "lacuna-diagnosis/1")
        self.assertEqual(found["verdict"], "consistent")
        self.assertIn("joint_2.gain", found["parameters"])

    def test_refuse_what_does_not_fit(self):
        with self.assertRaises(lacuna.InputError):
            lacuna.identify(joint_2(), optimizer="no such")
        with self.assertRaises(lacuna.InputError):
            lacuna.diagnose(joint_2(), engine="no such")


    def test_diff_refuses_two_machines(self):
        other = lacuna.Scenario(os.path.join(SCENARIOS, "double_pendulum", "scenario.yaml"))
        with self.assertRaisesRegex(lacuna.InputError, "robot"):
            lacuna.diff(joint_2(), other)


class LongCalls(unittest.TestCase):
    # Thousands of generations: minutes, were they not interrupted.
    def long_call(self):
        lacuna.identify(joint_2(), optimizer="ga", population=200, generations=5000, threads=1)

    def test_end_at_ctrl_c(self):
        for _ in range(2):  # a second time: the first has left nothing behind
            timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
            timer.start()
            begun = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                self.long_call()
            self.assertLess(time.monotonic() - begun, 20.0)
            timer.join()

    def test_diff_ends_at_ctrl_c(self):
        timer = threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        begun = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            lacuna.diff(joint_2(), joint_2(), optimizer="ga", population=200, generations=5000, threads=1)
        self.assertLess(time.monotonic() - begun, 20.0)
        timer.join()

    def test_let_other_threads_run(self):
        ticks = 0

        def tick():
            nonlocal ticks
            while ticks < 20:
                time.sleep(0.01)
                ticks += 1
            os.kill(os.getpid(), signal.SIGINT)  # only reached while the call below is at work

        thread = threading.Thread(target=tick)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            self.long_call()
        thread.join()
        self.assertEqual(ticks, 20)


if __name__ == "__main__":
    unittest.main()
