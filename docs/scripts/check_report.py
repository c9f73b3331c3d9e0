#!/usr/bin/env python3
"""Opens a report in headless Chromium and tries what a reader would.

    python3 docs/scripts/check_report.py out/overview [--screenshots DIR]

The folder is one that `loc-sim run` wrote. The report has to load without an error on the console,
show at a given time the pose that `estimate_<method>.tum` has there, play, go to the end by
keyboard and by slider, be scrubbed smoothly, be reached by the Tab key, show the scenario or the
command, and fit on screens 360 and 1600 pixels wide, light and dark. It must not be larger than
15 MB. Needs chromium and chromedriver; without them it says so and leaves with 0. Nothing but Python's own library.
"""

import argparse
import base64
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request


class Browser:
    """A headless Chromium, by the WebDriver protocol."""

    def __init__(self, chromium, driver):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.process = subprocess.Popen(
            [driver, f"--port={port}"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        self.base = f"http://127.0.0.1:{port}"
        self.profile = tempfile.TemporaryDirectory()
        arguments = [
            "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--disable-sync",
            "--hide-scrollbars", f"--user-data-dir={self.profile.name}",
        ]
        wanted = {
            "browserName": "chrome",
            "goog:chromeOptions": {"binary": chromium, "args": arguments},
            "goog:loggingPrefs": {"browser": "ALL"},
        }
        for attempt in range(50):
            try:
                answer = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
                break
            except OSError:
                if attempt == 49:
                    raise
                time.sleep(0.2)
        self.base += f"/session/{answer['sessionId']}"

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data, method=method)
        request.add_header("Content-Type", "application/json")
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def cdp(self, command, **parameters):
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def press(self, key):
        keys = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self.call("POST", "/actions", {"actions": [{"type": "key", "id": "keys", "actions": keys}]})

    def screen(self, width, height, dark):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height,
                 deviceScaleFactor=1, mobile=False)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.cdp("Emulation.setEmulatedMedia", features=[scheme])

    def errors(self):
        log = self.call("POST", "/se/log", {"type": "browser"})
        return [entry["message"] for entry in log if entry["level"] in ("SEVERE", "WARNING")]

    def screenshot(self, file):
        file.write_bytes(base64.b64decode(self.call("GET", "/screenshot")))

    def close(self):
        try:
            self.call("DELETE", "")
        finally:
            self.process.terminate()
            self.process.wait()


def wait(browser, script, what, seconds=20):
    for _ in range(int(seconds / 0.1)):
        if browser.run(script):
            return
        time.sleep(0.1)
    raise AssertionError(f"{what}: not within {seconds} s")


LARGEST = 15_000_000

# Moves the slider at every frame of the screen, as a hand does, and notes how long each took.
SCRUB = """
const done = arguments[arguments.length - 1], slider = document.querySelector('#time'), n = 120;
const times = [];
let k = 0, last = performance.now();
const frame = () => {
  const now = performance.now();
  if (k > 0) times.push(now - last);
  last = now;
  if (k++ === n) return done(times);
  slider.value = Math.round((0.5 - 0.5 * Math.cos(2 * Math.PI * k / n)) * slider.max);
  slider.dispatchEvent(new Event('input', {bubbles: true}));
  requestAnimationFrame(frame);
};
requestAnimationFrame(frame);
"""


def scrub(browser):
    times = sorted(browser.call("POST", "/execute/async", {"script": SCRUB, "args": []}))
    median, slow = times[len(times) // 2], times[int(0.95 * len(times))]
    # A loaded machine is slow now and then; 30 frames a second are smooth.
    assert median < 34, f"scrubbing takes {median:.1f} ms a frame"
    assert slow < 100, f"scrubbing takes up to {slow:.1f} ms a frame"
    return median, slow


def check(browser, folder, screenshots):
    size = (folder / "report.html").stat().st_size
    assert size < LARGEST, f"{size / 1e6:.1f} MB"
    browser.screen(1600, 1000, dark=False)
    browser.open((folder / "report.html").resolve().as_uri())
    wait(browser, "return document.querySelector('.player')?.dataset.ready === 'true'", "the player starts")

    # The pose at a time is the one of the file.
    method = browser.run("return player.run.methods[player.state.focus].name")
    lines = (folder / f"estimate_{method}.tum").read_text().splitlines()
    rows = [line.split() for line in lines if not line.startswith("#")]
    row = rows[len(rows) // 3]
    start = float(rows[0][0])
    browser.run("player.show(arguments[0])", float(row[0]) - start)
    x, y, _ = browser.run("return player.pose()")
    assert abs(x - float(row[1])) < 1e-4 and abs(y - float(row[2])) < 1e-4, (x, y, row)
    shown = browser.run("return document.querySelector('#clock').textContent")
    assert shown.startswith(f"{float(row[0]) - start:.1f} of"), shown
    if screenshots:
        time.sleep(0.3)
        browser.screenshot(screenshots / "wide-light.png")

    # It plays, by the keyboard, and stops.
    before = browser.run("return player.state.time")
    browser.press(" ")
    wait(browser, f"return player.state.time > {before} + 1", "playing goes on")
    browser.press(" ")
    assert not browser.run("return player.state.playing"), "space pauses"

    # To the end and back, by the keyboard and by the slider.
    browser.press("\ue010")
    last, count = browser.run("return [player.state.frame, player.run.stamps.length]")
    assert last == count - 1, (last, count)
    browser.run(
        "const s = document.querySelector('#time'); s.value = arguments[0];"
        "s.dispatchEvent(new Event('input', {bubbles: true}))", count // 2)
    assert browser.run("return player.state.frame") == count // 2
    browser.press("\ue011")
    assert browser.run("return player.state.frame") == 0
    # Scrubbing through all of it is smooth: a frame takes less than 50 ms on the average.
    mean = browser.run(
        "const n = 100, from = performance.now();"
        "for (let k = 0; k < n; k++) player.show(player.run.stamps[Math.floor(k * player.run.stamps.length / n)]);"
        "return (performance.now() - from) / n")
    assert mean < 50, f"{mean:.1f} ms a frame"

    median, slow = scrub(browser)
    # Everything that can be operated is reached by the Tab key.
    browser.run("document.activeElement.blur()")
    reached = set()
    for _ in range(40):
        browser.press("\ue004")
        reached.add(browser.run("const e = document.activeElement; return e.id || e.name || e.className || e.tagName"))
    missing = {"scene", "play", "time", "speed", "focus", "whole"} - reached
    assert not missing, f"the Tab key does not reach {missing}"
    made = browser.run("return [...document.querySelectorAll('h2')].pop().nextElementSibling.textContent")
    assert made.startswith("loc-sim"), made

    for width, height, dark in [(1600, 1000, True), (360, 740, False), (360, 740, True)]:
        browser.screen(width, height, dark)
        time.sleep(0.3)
        browser.run("player.show(arguments[0])", float(row[0]) - start)
        overflow = browser.run("return document.documentElement.scrollWidth - window.innerWidth")
        assert overflow <= 0, f"{overflow} px too wide on a screen of {width} px"
        if screenshots:
            time.sleep(0.2)
            browser.screenshot(screenshots / f"{width}-{'dark' if dark else 'light'}.png")
    errors = browser.errors()
    assert not errors, errors
    print(f"{folder / 'report.html'}: {size / 1e6:.1f} MB, loads, plays and scrubs "
          f"({mean:.1f} ms to draw, {median:.1f} ms a frame, 95 % below {slow:.1f} ms), fits from 360 to 1600 px")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--screenshots", type=pathlib.Path)
    arguments = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if not chromium or not driver:
        print("skipped: chromium and chromedriver are not installed")
        return
    if arguments.screenshots:
        arguments.screenshots.mkdir(parents=True, exist_ok=True)
    browser = Browser(chromium, driver)
    try:
        check(browser, arguments.folder, arguments.screenshots)
    finally:
        browser.close()


if __name__ == "__main__":
    try:
        main()
    except AssertionError as error:
        sys.exit(f"the report fails: {error}")
