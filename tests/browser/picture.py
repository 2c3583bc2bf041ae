#!/usr/bin/env python3
"""A picture of one section of a report, scripts run: picture.py REPORT SECTION PICTURE.png [WIDTH HEIGHT]

    tests/browser/picture.py out/demo/report.html Replay docs/report.png
"""

import sys
from pathlib import Path

from webdriver import Browser, missing

if len(sys.argv) not in (4, 6):
    sys.exit(__doc__)
if missing():
    sys.exit(missing())
page, section, picture = sys.argv[1:4]
width, height = map(int, sys.argv[4:6] or (1100, 760))
with Browser(width, height) as browser:
    browser.open(Path(page))
    browser.wait("return document.documentElement.dataset.page === 'started'")
    found = browser.run("""const title = [...document.querySelectorAll('h2')].find((h) => h.textContent === arguments[0]);
        if (title) title.scrollIntoView(); return Boolean(title)""", section)
    if not found:
        sys.exit(f"{page}: no section {section!r}")
    browser.run("return new Promise((done) => setTimeout(done, 1000))")  # until what came into view is drawn
    Path(picture).write_bytes(browser.picture())
