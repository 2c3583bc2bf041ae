"""A browser driven through the W3C WebDriver protocol, with nothing but the standard library.

    with Browser() as browser:
        browser.open(Path("report.html"))
        browser.run("return document.title")
"""

import base64
import json
import os
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request

ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the protocol's name of a reference to an element


def missing():
    """Why no browser can be driven here; empty where one can."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return f"{program} is not installed (Debian: chromium, chromium-driver)"
    return ""


class Browser:
    """A headless Chromium with an empty profile; `dark`: the reader prefers dark pages."""

    def __init__(self, width=1280, height=900, dark=False):
        self.width, self.height, self.dark = width, height, dark

    def __enter__(self):
        self.profile = tempfile.TemporaryDirectory(prefix="lacuna-browser-", ignore_cleanup_errors=True)
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        try:
            self.base = f"http://127.0.0.1:{self._port()}"
            self.session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": self._wishes()}})["sessionId"]
        except BaseException:
            self.driver.terminate()
            raise
        return self

    def __exit__(self, *_):
        try:
            self._call("DELETE", f"/session/{self.session}")
        finally:
            self.driver.terminate()
            self.driver.wait(timeout=30)
            self.driver.stdout.close()
            self.profile.cleanup()

    def _port(self):
        for line in self.driver.stdout:
            found = re.search(r"started successfully on port (\d+)", line)
            if found:
                return int(found[1])
        raise RuntimeError("chromedriver ended before it listened")

    def _wishes(self):
        arguments = ["--headless", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
                     "--disable-component-update", "--disable-sync", "--force-device-scale-factor=1",
                     f"--user-data-dir={self.profile.name}", f"--window-size={self.width},{self.height}"]
        if os.geteuid() == 0:
            arguments.append("--no-sandbox")
        if self.dark:
            arguments.append("--blink-settings=preferredColorScheme=0")
        return {"browserName": "chrome", "goog:chromeOptions": {"binary": shutil.which("chromium"), "args": arguments},
                "goog:loggingPrefs": {"browser": "ALL"}}

    def _call(self, method, path, body=None):
        data = json.dumps(body if body is not None else {}).encode() if method == "POST" else None
        request = urllib.request.Request(self.base + path, data, {"Content-Type": "application/json"}, method=method)
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        try:
            with opener.open(request, timeout=120) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            said = json.load(error)["value"]
            raise RuntimeError(f"{said['error']}: {said['message']}") from None

    def _command(self, path, body=None):
        return self._call("POST", f"/session/{self.session}/{path}", body)

    def devtools(self, command, **parameters):
        return self._command("goog/cdp/execute", {"cmd": command, "params": parameters})

    def open(self, file):
        self.messages()  # those of the page before
        self._command("url", {"url": file.resolve().as_uri()})

    def run(self, script, *arguments):
        """The value of `return ...` in the page."""
        return self._command("execute/sync", {"script": script, "args": list(arguments)})

    def wait(self, script, *arguments):
        """Until `return ...` is true; at most 30 s. Gives its value."""
        until = time.monotonic() + 30
        while True:
            value = self.run(script, *arguments)
            if value or time.monotonic() > until:
                return value
            time.sleep(0.03)

    def messages(self):
        """What the console has said since it was last asked."""
        return [entry["message"] for entry in self._command("se/log", {"type": "browser"})]

    def find(self, selector):
        return self._command("element", {"using": "css selector", "value": selector})

    def press(self, key):
        self._command("actions", {"actions": [{"type": "key", "id": "keys", "actions": [
            {"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]}]})

    def point(self, selector, *moves):
        """A mouse over the element: ("move", x, y) from its middle in px, ("down",), ("up",)."""
        element = self.find(selector)
        actions = []
        for move in moves:
            if move[0] == "move":
                actions.append({"type": "pointerMove", "duration": 50, "origin": element, "x": move[1], "y": move[2]})
            else:
                actions.append({"type": "pointerDown" if move[0] == "down" else "pointerUp", "button": 0})
        self._command("actions", {"actions": [{"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
                                               "actions": actions}]})

    def picture(self):
        """The window as a PNG file's bytes."""
        return base64.b64decode(self._call("GET", f"/session/{self.session}/screenshot"))
