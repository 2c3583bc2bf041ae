#!/usr/bin/env python3
"""Reports in a real browser: pages_test.py WRITE_PAGES [UNITTEST-OPTION...]

WRITE_PAGES writes the pages (write_pages.cc). Where LACUNA_PICTURES names a folder, pictures of what was seen go there.
"""

import math
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from webdriver import Browser, missing

WRITE_PAGES = ""
MOST_BYTES = 5_000_000
FIRST_PICTURE = 1500  # ms
SKIPPED = 77          # what ctest takes for a test that could not run

LIVE = "return document.querySelectorAll('.plot.drawn').length"
RANGES = """return [...document.querySelectorAll('.plot.drawn .live-area')]
    .filter((area) => area.closest('.plot').dataset.recording === arguments[0])
    .map((area) => [Number(area.dataset.from), Number(area.dataset.to)])"""
INK = """const canvas = document.querySelectorAll(arguments[0])[arguments[1]];
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    let sum = 0; for (let i = 0; i < data.length; i += 4) sum = (sum * 31 + data[i] + 3 * data[i + 1] + 7 * data[i + 2] + data[i + 3]) % 1000000007;
    let filled = 0; for (let i = 3; i < data.length; i += 4) filled += data[i] > 128;
    return [sum, filled / (data.length / 4)]"""
FIRST_PLOT = ".plot.drawn[data-recording='test_1.csv'] .live-area"


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.keep = tempfile.TemporaryDirectory(prefix="lacuna-pages-")
        cls.folder = Path(cls.keep.name)
        subprocess.run([WRITE_PAGES, cls.keep.name], check=True)
        cls.browser = Browser().__enter__()

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()
        cls.keep.cleanup()

    def tearDown(self):
        pictures = os.environ.get("LACUNA_PICTURES")
        if pictures:
            Path(pictures, self._testMethodName + ".png").write_bytes(self.browser.picture())

    def opened(self, name):
        self.browser.open(self.folder / name)
        self.browser.wait("return document.documentElement.dataset.page === 'started'")

    def to_plots(self):
        """Scrolls to the first plot of the test recording and waits until it is drawn."""
        self.browser.run("document.querySelector(\".plot[data-recording='test_1.csv']\").scrollIntoView({block: 'center'})")
        self.assertTrue(self.browser.wait(f"return document.querySelector(\"{FIRST_PLOT}\") !== null"))

    def time(self):
        self.browser.run("return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")
        return float(self.browser.run("return document.querySelector('.replay-stage').dataset.time"))

    def test_loads_and_draws_without_a_complaint(self):
        self.opened("usual.html")
        self.to_plots()
        self.assertGreater(self.browser.run(LIVE), 1)
        filled = self.browser.run(INK, FIRST_PLOT + " canvas", 0)
        self.assertGreater(filled[1], 0.001, "the plot's canvas has lines on it")
        self.assertEqual(self.browser.messages(), [])

    def test_first_picture_comes_soon_and_the_file_is_small(self):
        self.assertLess((self.folder / "usual.html").stat().st_size, MOST_BYTES)
        self.opened("usual.html")
        paint = self.browser.wait("const p = performance.getEntriesByName('first-contentful-paint'); return p.length && p[0].startTime")
        self.assertGreater(paint, 0)
        self.assertLess(paint, FIRST_PICTURE)

    def test_asks_for_nothing_outside_itself(self):
        self.opened("usual.html")
        self.to_plots()
        self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').map((r) => r.name).filter((n) => !n.startsWith('data:'))"), [])
        policy = self.browser.run("return document.querySelector('meta[http-equiv]').content")
        self.assertIn("default-src 'none'", policy)
        self.assertNotIn("script-src 'unsafe-inline'", policy)

    def test_a_zoom_is_shared_by_all_plots_of_the_recording(self):
        self.opened("usual.html")
        self.to_plots()
        before = self.browser.run(RANGES, "test_1.csv")
        self.assertGreater(len(before), 1)
        self.browser.point(FIRST_PLOT, ("move", -150, 0), ("down",), ("move", 100, 2), ("up",))
        after = self.browser.run(RANGES, "test_1.csv")
        self.assertLess(after[0][1] - after[0][0], 0.6 * (before[0][1] - before[0][0]))
        for other in after[1:]:
            self.assertAlmostEqual(other[0], after[0][0], places=6)
            self.assertAlmostEqual(other[1], after[0][1], places=6)
        self.browser.point(FIRST_PLOT, ("down",), ("up",), ("down",), ("up",))
        for was, now in zip(before, self.browser.run(RANGES, "test_1.csv")):
            self.assertAlmostEqual(was[0], now[0], places=3)
            self.assertAlmostEqual(was[1], now[1], places=3)

    def test_the_cursor_is_shared_and_moves_the_replay(self):
        self.opened("usual.html")
        first_time, first_picture = self.time(), self.browser.run(INK, ".replay canvas", 0)
        self.assertGreater(first_picture[1], 0.02, "a robot is seen")
        self.to_plots()
        self.browser.point(FIRST_PLOT, ("move", 120, 0), ("move", 200, 0))
        self.assertNotAlmostEqual(self.time(), first_time, places=2)
        self.assertNotEqual(self.browser.run(INK, ".replay canvas", 0)[0], first_picture[0])
        places = self.browser.run("""return [...document.querySelectorAll(".plot.drawn[data-recording='test_1.csv'] .live-cursor")]
            .map((line) => line.hidden ? -1 : line.getBoundingClientRect().left - line.parentElement.getBoundingClientRect().left)""")
        self.assertGreater(len(places), 1)
        self.assertGreater(min(places), 0)
        self.assertTrue(self.browser.run("return document.querySelector('.replay-stage').classList.contains('floating')"))

    def test_keys_move_the_cursor_and_zoom(self):
        self.opened("usual.html")
        self.to_plots()
        self.browser.run(f"document.querySelector(\"{FIRST_PLOT}\").focus()")
        was = self.time()
        self.browser.press("\ue014")  # arrow right
        self.assertAlmostEqual(self.time() - was, 0.1, places=2)
        width = self.browser.run(RANGES, "test_1.csv")[0]
        self.browser.press("+")
        narrower = self.browser.run(RANGES, "test_1.csv")[0]
        self.assertLess(narrower[1] - narrower[0], 0.7 * (width[1] - width[0]))
        self.browser.press("0")
        self.assertAlmostEqual(self.browser.run(RANGES, "test_1.csv")[0][1], width[1], places=3)

    def test_plays_and_pauses(self):
        self.opened("usual.html")
        self.browser.run("document.querySelector('.replay').scrollIntoView()")
        self.browser.run("const s = document.querySelector('.replay-slider'); s.value = s.min; s.dispatchEvent(new Event('input'))")
        self.assertAlmostEqual(self.time(), 0.0, places=3)
        self.browser.run("document.querySelector('.replay-play').click()")
        self.assertTrue(self.browser.wait("return Number(document.querySelector('.replay-stage').dataset.time) > 0.4"))
        self.browser.run("document.querySelector('.replay-play').click()")
        stopped = self.time()
        self.assertEqual(self.time(), stopped)

    def test_a_cylinder_reaches_from_pin_to_pin_in_every_pose(self):
        self.opened("cylinder.html")
        ends = """
          const data = readBlock(document.querySelector('script.replay-data')), figure = new Figure(data.solids);
          const poses = bodyPoses(data.joints, data.joints.map((joint, i) => (i === 1 ? arguments[0] : 0)));
          return figure.solids.filter((solid) => solid.between).map((solid) => {
            const { pose, mesh } = figure.placed(solid, poses);
            const zs = mesh.flatMap(([points]) => [points[2], points[5], points[8]]);
            return [Math.min(...zs), Math.max(...zs)].map((z) => [0, 1, 2].map((k) => pose[9 + k] + pose[6 + k] * z));
          });"""
        for q in (-0.4, 0.0, 0.7):
            (pin, gland), (end, moved) = self.browser.run(ends, q)
            self.assertLess(math.dist(gland, end), 1e-4, "the rod leaves the barrel where it ends")
            # Two sides and the angle between them give the third.
            length = math.sqrt(0.3**2 + 0.08**2 - 2 * 0.3 * 0.08 * math.cos(q + 1.0))
            self.assertAlmostEqual(math.dist(pin, moved), length, delta=1e-4)

    def test_meshes_are_drawn_coarser_and_the_page_stays_small(self):
        self.assertLess((self.folder / "meshed.html").stat().st_size, MOST_BYTES)
        self.opened("meshed.html")
        self.browser.run("document.querySelector('.replay').scrollIntoView()")
        self.browser.run("const s = document.querySelector('.replay-slider'); s.value = 5; s.dispatchEvent(new Event('input'))")
        self.time()
        first = self.browser.run(INK, ".replay canvas", 0)
        self.assertGreater(first[1], 0.03, "the balls cover part of the picture")
        self.browser.run("const s = document.querySelector('.replay-slider'); s.value = 8; s.dispatchEvent(new Event('input'))")
        self.time()
        self.assertNotEqual(self.browser.run(INK, ".replay canvas", 0)[0], first[0])
        self.assertIn("The meshes are drawn coarser here", self.browser.run("return document.body.innerText"))
        # The browser remarks that a canvas is read twice, which only this test does.
        self.assertEqual([m for m in self.browser.messages() if "willReadFrequently" not in m], [])

    def test_numbers_and_colour_at_the_cursor_are_those_of_the_recording(self):
        self.opened("usual.html")
        self.browser.run("const s = document.querySelector('.replay-slider'); s.value = 10; s.dispatchEvent(new Event('input'))")
        self.time()
        cells = self.browser.run("return [...document.querySelectorAll('.replay-table tbody tr')][1].innerText.split('\\t')")
        number = lambda words: float(words.replace("\u2212", "-"))
        # write_pages.cc: joint_2 at 10 s, deviation .02 cos(.6 x 10) and effort .5 cos(6) over a noise of .01.
        self.assertEqual(cells[0], "joint_2")
        self.assertAlmostEqual(number(cells[2]), 0.0192, delta=4e-4)
        self.assertAlmostEqual(number(cells[5]), 48.0, delta=0.2)
        self.assertLess(abs(number(cells[6])), 1.01)

    def test_a_finding_lights_up_where_and_when_it_acts(self):
        self.opened("usual.html")
        lit = "return [...document.querySelectorAll('.replay-table tr.lit')].map((row) => row.innerText.split('\\t')[0].trim())"
        self.assertEqual(self.browser.run(lit), [])
        self.browser.run("document.querySelector('tr.acts').focus()")
        self.time()
        self.assertEqual(self.browser.run(lit), ["joint_2"])
        self.browser.press("\ue007")  # Enter: goes there
        self.assertEqual(self.browser.run("return document.querySelector('.replay-options select').selectedOptions[0].textContent"),
                         "validate_1.csv (validate)")
        self.assertAlmostEqual(self.time(), 2.25, places=3)
        self.assertTrue(self.browser.run("""return [...document.querySelectorAll('details')].some((fold) => fold.open &&
            fold.querySelector(".plot[data-recording='validate_1.csv']"))"""))

    def test_hostile_names_stay_text(self):
        self.opened("hostile.html")
        self.browser.run("document.querySelectorAll('details').forEach((fold) => (fold.open = true))")
        plots = self.browser.run("return document.querySelectorAll('.plot').length")
        for i in range(plots):
            self.browser.run("document.querySelectorAll('.plot')[arguments[0]].scrollIntoView()", i)
            self.assertTrue(self.browser.wait("return document.querySelectorAll('.plot')[arguments[0]].classList.contains('drawn')", i))
        self.browser.run("document.querySelectorAll('.acts').forEach((each) => each.focus())")
        self.time()
        self.assertIsNone(self.browser.run("return window.hacked || null"))
        self.assertEqual(self.browser.run("return document.querySelectorAll('[onerror], [src=x]').length"), 0)
        self.assertIn("<script>window.hacked=1</script>", self.browser.run("return document.querySelector('.replay-table').textContent"))
        self.assertIn("<script>window.hacked=1</script>", self.browser.run("return document.querySelector('.live-title').textContent + document.querySelector('.replay-options').textContent"))
        self.assertEqual(self.browser.messages(), [])

    def test_a_script_that_is_not_ours_does_not_run(self):
        self.opened("usual.html")
        text = (self.folder / "usual.html").read_text(errors="replace")
        (self.folder / "planted.html").write_text(text.replace("<h2>", "<script>window.hacked=1</script><img src=x onerror='window.hacked=2'><h2>", 1))
        self.opened("planted.html")
        self.assertIsNone(self.browser.run("return window.hacked || null"))
        self.assertTrue(any("Content Security Policy" in message for message in self.browser.messages()))

    def test_without_scripts_the_drawings_stay(self):
        self.browser.devtools("Emulation.setScriptExecutionDisabled", value=True)
        try:
            self.browser.open(self.folder / "usual.html")
            self.assertEqual(self.browser.run(LIVE), 0)
            visible = self.browser.run("return [...document.querySelectorAll('.plot > svg')].filter((svg) => svg.getBoundingClientRect().height > 50).length")
            self.assertGreater(visible, 2)
            self.assertIn("needs a browser that runs scripts", self.browser.run("return document.querySelector('.replay').innerText"))
        finally:
            self.browser.devtools("Emulation.setScriptExecutionDisabled", value=False)

    def test_one_model_is_one_picture(self):
        self.opened("consistent.html")
        self.assertEqual(self.browser.run("return document.querySelectorAll('.replay canvas').length"), 1)
        self.assertEqual(self.browser.messages(), [])

    def test_nothing_is_wider_than_a_narrow_window_but_what_scrolls(self):
        self.browser.devtools("Emulation.setDeviceMetricsOverride", width=420, height=800, deviceScaleFactor=1, mobile=False)
        try:
            self.opened("usual.html")
            self.assertLessEqual(self.browser.run("return document.documentElement.scrollWidth"), 420)
            cut = self.browser.run("""return [...document.querySelectorAll('table')].filter((table) => {
                const box = table.parentElement; return table.scrollWidth > box.clientWidth + 1 &&
                getComputedStyle(box).overflowX !== 'auto'; }).length""")
            self.assertEqual(cut, 0)
        finally:
            self.browser.devtools("Emulation.clearDeviceMetricsOverride")


if __name__ == "__main__":
    WRITE_PAGES = sys.argv.pop(1)
    if missing():
        print(missing())
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
