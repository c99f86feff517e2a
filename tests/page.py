"""Opens pages in headless Chromium and tells what happened, one line a page, as JSON.

page.py [--pictures] FOLDER PAGE...: pages in the folder. Needs chromium and chromedriver on the path, nothing else.
Each page is printed beside itself, NAME.pdf. For a person to look at, `--pictures` adds NAME.png, NAME.dark.png,
NAME.phone.png and NAME.arm.png; nothing is judged by them.

A headless browser now and then stops answering (a picture waits for a frame that its compositor never draws),
whatever page it shows; without frames a chart does not hear that it has come into sight either. A page has a
browser of its own, an answer a minute, a chart twenty seconds, and a page whose browser fell silent is looked
at again with a new one. A page that silences three is at fault itself.
"""

import base64
import http.client
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--disable-backgrounding-occluded-windows", "--disable-renderer-backgrounding",
]  # fmt: skip

ANSWER_S = 60
CHART_S = 20
BROWSERS = 3
# what a driver says of a browser that crashed or hangs
GONE = {"timeout", "script timeout", "session not created", "invalid session id", "no such window",
        "disconnected", "tab crashed", "chrome not reachable"}  # fmt: skip


class Silent(Exception):
    """A browser that does not answer, or draws nothing."""


class Browser:
    """A WebDriver session."""

    def __init__(self, profile):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.driver = subprocess.Popen(
            ["chromedriver", f"--port={port}"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.root = f"http://127.0.0.1:{port}"
        try:
            self.start(profile)
        except BaseException:
            self.close()
            raise

    def start(self, profile):
        for _ in range(150):
            try:
                if self.call("GET", "/status")["ready"]:
                    break
            except Silent:
                time.sleep(0.2)
        options = {"args": [*FLAGS, f"--user-data-dir={profile}", "--window-size=1200,900"]}
        wanted = {
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"},
        }
        session = self.call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.root += "/session/" + session["sessionId"]
        limit = 1000 * (ANSWER_S - 5)
        self.call("POST", "/timeouts", {"script": limit, "pageLoad": limit})

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(
            self.root + path, data, {"Content-Type": "application/json"}, method=method
        )
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        try:
            with opener.open(request, timeout=ANSWER_S) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            said = json.load(error)["value"]
            kind = Silent if said["error"] in GONE else RuntimeError
            raise kind(f"{method} {path}: {said['error']}: {said['message'][:500]}") from None
        except (TimeoutError, urllib.error.URLError, ConnectionError, http.client.HTTPException) as fault:
            raise Silent(f"{method} {path}: {fault!r} (limit {ANSWER_S} s)") from None

    def run(self, script, *arguments):
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def devtools(self, command, **parameters):
        body = {"cmd": command, "params": parameters}
        return self.call("POST", "/goog/cdp/execute", body)

    def log(self, kind):
        return self.call("POST", "/se/log", {"type": kind})

    def close(self):
        # the driver and the browser it started, also when neither answers any more
        try:
            self.call("DELETE", "")
        except (Silent, RuntimeError):
            pass
        os.killpg(self.driver.pid, signal.SIGKILL)
        self.driver.wait()


def wait(browser, script, seconds=90):
    """Whether a condition comes true."""
    end = time.time() + seconds
    while time.time() < end:
        if browser.run("return " + script):
            return True
        time.sleep(0.2)
    return False


def screen(browser, width, height):
    browser.devtools(
        "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False
    )
    # charts follow the width of their page
    time.sleep(0.7)


def picture(browser, path, width, height, dark=False):
    media = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
    browser.devtools("Emulation.setEmulatedMedia", features=media)
    screen(browser, width, height)
    data = browser.devtools("Page.captureScreenshot", format="png")["data"]
    path.write_bytes(base64.b64decode(data))


VISIBLE = "[...document.querySelectorAll('.chart')].filter((c) => c.offsetParent)"
# what a chart holds once its lines, map or picture are in it
DRAWN = "querySelector('.main-svg .trace, .main-svg .hm, .main-svg image')"


def look(browser, page, pictures):
    start = time.time()
    browser.call("POST", "/url", {"url": page.as_uri()})
    ready = wait(browser, "document.documentElement.dataset.ready === 'true'")
    seconds = time.time() - start
    folder, name = page.parent, page.stem
    if pictures:
        picture(browser, folder / f"{name}.png", 1200, 1600)
        picture(browser, folder / f"{name}.dark.png", 1200, 1600, dark=True)
    # what is wider than the screen of a phone makes the page scroll sideways
    screen(browser, 390, 1600)
    if pictures:
        picture(browser, folder / f"{name}.phone.png", 390, 1600)
    overflow = browser.run("return document.documentElement.scrollWidth - innerWidth")
    screen(browser, 1200, 900)
    closed = browser.run("return document.querySelectorAll('details:not([open])').length")
    browser.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    for number in range(browser.run(f"return {VISIBLE}.length")):
        browser.run(f"{VISIBLE}[{number}].scrollIntoView({{block: 'center', behavior: 'instant'}})")
        if not wait(browser, f"!!{VISIBLE}[{number}].{DRAWN}", CHART_S):
            raise Silent(f"chart {number + 1} is in sight and was not drawn within {CHART_S} s")
    charts = browser.run(f"return {VISIBLE}.length")
    drawn = browser.run(f"return {VISIBLE}.filter((c) => c.{DRAWN}).length")
    # every view of every chart is drawn once
    views = 0
    for select in range(browser.run("return document.querySelectorAll('.control select').length")):
        views += browser.run(
            f"const s = document.querySelectorAll('.control select')[{select}];"
            " for (const o of s.options) { s.value = o.value; s.dispatchEvent(new Event('change')); }"
            " return s.options.length"
        )
    for slider in range(browser.run("return document.querySelectorAll('.control input').length")):
        browser.run(
            f"const s = document.querySelectorAll('.control input')[{slider}];"
            " s.value = s.max / 2; s.dispatchEvent(new Event('input'))"
        )
    lit = light(browser)
    hovered = hover(browser)
    if pictures and browser.run("return !!document.getElementById('skeleton')"):
        browser.run("document.getElementById('skeleton').scrollIntoView({block: 'center', behavior: 'instant'})")
        picture(browser, folder / f"{name}.arm.png", 1200, 900)
    pdf = browser.call("POST", "/print", {"background": True})
    (folder / f"{name}.pdf").write_bytes(base64.b64decode(pdf))
    errors = [e["message"] for e in browser.log("browser") if e["level"] in ("SEVERE", "WARNING")]
    requests = []
    for entry in browser.log("performance"):
        event = json.loads(entry["message"])["message"]
        if event["method"] == "Network.requestWillBeSent":
            url = event["params"]["request"]["url"]
            if url != page.as_uri() and not url.startswith(("data:", "blob:", "chrome:")):
                requests.append(url)
    return {
        "page": page.name, "ready": ready, "seconds": round(seconds, 2), "charts": charts, "drawn": drawn,
        "views": views, "closed": closed, "lit": lit, "hovered": hovered, "overflow": overflow, "errors": errors,
        "requests": requests,
    }  # fmt: skip


def light(browser):
    """What the arm says of the first finding once its button is pressed; none without one."""
    if not browser.run("return !!document.querySelector('button.light')"):
        return None
    browser.run("document.querySelector('button.light').click()")
    wait(browser, "!!document.getElementById('skeleton').dataset.lit", 5)
    # the cells of the residual map in which it acts are framed, whichever joint's it is
    framed = "document.querySelector('.chart[data-framed=\"0\"]')"
    frames = browser.run(f"const c = {framed}; if (!c) return 0; c.scrollIntoView(); return 1") and (
        wait(browser, f"{framed}.querySelectorAll('.shapelayer path').length > 0", 5)
    )
    return bool(frames), *browser.run(
        "const s = document.getElementById('skeleton');"
        " return [s.dataset.lit, s.nextElementSibling.textContent, s.querySelectorAll('.legendtext').length,"
        " [...s.querySelectorAll('.legendtext')].some((t) => t.textContent === s.dataset.lit)]"
    )


def hover(browser):
    """Whether the first chart with lines says its values under the pointer."""
    found = browser.run(
        f"const c = {VISIBLE}.find((c) => c.querySelector('.scatterlayer .trace'));"
        " if (!c) return false; c.scrollIntoView({block: 'center', behavior: 'instant'}); c.dataset.hovering = '1';"
        " return true"
    )
    if not found:
        return None
    time.sleep(0.5)
    found = browser.run(
        "const r = document.querySelector('[data-hovering] .nsewdrag').getBoundingClientRect();"
        " return [r.x + r.width / 2, r.y + r.height / 2]"
    )
    for step in range(3):
        x, y = round(found[0]) + step, round(found[1])
        moves = [{"type": "pointerMove", "duration": 100, "x": x, "y": y}]
        pointer = {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"}, "actions": moves}
        browser.call("POST", "/actions", {"actions": [pointer]})
    return wait(browser, "!!document.querySelector('[data-hovering] .hoverlayer').childElementCount", 5)


def look_anew(page, pictures):
    """What a page does in a browser of its own."""
    profile = tempfile.mkdtemp(prefix="armident-chromium-")
    browser = None
    try:
        browser = Browser(profile)
        return look(browser, page, pictures)
    finally:
        if browser is not None:
            browser.close()
        shutil.rmtree(profile, ignore_errors=True)


def main():
    arguments = sys.argv[1:]
    pictures = "--pictures" in arguments
    folder, *names = [a for a in arguments if a != "--pictures"]
    for name in names:
        page = pathlib.Path(folder).resolve() / name
        for tried in range(1, BROWSERS + 1):
            try:
                print(json.dumps(look_anew(page, pictures)), flush=True)
                break
            except Silent as fault:
                print(f"{name}: {fault}; browser {tried} of {BROWSERS}", file=sys.stderr, flush=True)
                if tried == BROWSERS:
                    raise


if __name__ == "__main__":
    main()
