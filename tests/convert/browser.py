"""A headless Chromium driven through its pipe: what the tests of the viewer look through."""
# SPDX-License-Identifier: Apache-2.0
import base64
import json
import os
import shutil
import struct
import subprocess
import tempfile
import time
import zlib

CHROMIUM = shutil.which("chromium")

# No display and no GPU: what is drawn comes from SwiftShader. No network, no first-run pages.
FLAGS = ["--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--disable-dev-shm-usage", "--no-first-run", "--disable-extensions", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--mute-audio", "--hide-scrollbars"]


class Browser:
    """One page. Raises RuntimeError where the browser answers with an error, TimeoutError where it does not answer."""

    def __init__(self, size=(800, 600), dark=False):
        self.profile = tempfile.mkdtemp(prefix="diesink-browser-")
        to_read, self.to = os.pipe()
        self.back, to_write = os.pipe()

        def as_descriptors_3_and_4():
            # Away from 3 and 4 first: one of the ends may be one of them.
            read, write = os.dup(to_read), os.dup(to_write)
            os.dup2(read, 3)
            os.dup2(write, 4)

        home = {**os.environ, "HOME": self.profile, "XDG_CONFIG_HOME": self.profile, "XDG_CACHE_HOME": self.profile}
        self.process = subprocess.Popen([CHROMIUM, *FLAGS, f"--user-data-dir={self.profile}", f"--window-size={size[0]},{size[1]}", "about:blank"],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=home,
                                        close_fds=False, preexec_fn=as_descriptors_3_and_4)
        os.close(to_read)
        os.close(to_write)
        self.buffer, self.number, self.session = b"", 0, None
        self.events = []
        target = next(each for each in self.call("Target.getTargets")["targetInfos"] if each["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ["Page", "Runtime", "Log", "Network"]:
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self.to)
        os.close(self.back)
        shutil.rmtree(self.profile, ignore_errors=True)

    def _message(self, deadline):
        while b"\0" not in self.buffer:
            if time.monotonic() > deadline:
                raise TimeoutError("the browser does not answer")
            os.set_blocking(self.back, False)
            try:
                more = os.read(self.back, 1 << 20)
            except BlockingIOError:
                time.sleep(0.005)
                continue
            if not more:
                raise RuntimeError("the browser has ended")
            self.buffer += more
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]
        deadline = time.monotonic() + 60
        while True:
            answer = self._message(deadline)
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def run(self, script):
        """The value of a JavaScript expression."""
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"].get("exception", {}).get("description", str(answer)))
        return answer["result"].get("value")

    def open(self, path, seconds=60):
        """Loads a file and waits until the viewer says that it is open, or has failed; gives which."""
        self.call("Page.navigate", url=f"file://{path}")
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            state = self.run("document.documentElement?.dataset.state")
            if state:
                return state
            time.sleep(0.02)
        raise TimeoutError("the page does not open")

    def complaints(self):
        """Texts of everything the console was told at level warning or error, and of exceptions."""
        self.run("0")  # what came before has arrived
        found = []
        for each in self.events:
            what = each.get("params", {})
            if each.get("method") == "Runtime.exceptionThrown":
                found.append(str(what["exceptionDetails"]))
            elif each.get("method") == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning", "assert"):
                found.append(" ".join(str(a.get("value", a.get("description"))) for a in what["args"]))
            elif each.get("method") == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
                found.append(what["entry"]["text"])
        return found

    def requests(self):
        """Addresses of everything the page asked for besides itself and data in it."""
        urls = [each["params"]["request"]["url"] for each in self.events if each.get("method") == "Network.requestWillBeSent"]
        return [url for url in urls if not url.startswith(("data:", "about:"))]

    def click(self, x, y):
        for kind in ["mousePressed", "mouseReleased"]:
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def drag(self, x, y, to_x, to_y):
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1)
        for k in range(1, 6):
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + (to_x - x) * k / 5, y=y + (to_y - y) * k / 5, button="left", buttons=1)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=to_x, y=to_y, button="left", buttons=0, clickCount=1)

    def frame(self):
        """Waits until what was asked for has been drawn."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def png(self, **options):
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", **options)["data"])

    def screenshot(self, x, y, width, height):
        """Rows of (r, g, b) of a part of the page, once it is drawn."""
        self.frame()
        return pixels(self.png(clip={"x": x, "y": y, "width": width, "height": height, "scale": 1}))


def pixels(data):
    """Rows of (r, g, b) of an 8-bit PNG."""
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", body)
            assert depth == 8 and color in (2, 6)
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    step = 3 if color == 2 else 4
    raw, rows, above = zlib.decompress(packed), [], bytes(step * width)
    for j in range(height):
        begin = j * (step * width + 1)
        kind, line = raw[begin], bytearray(raw[begin + 1:begin + 1 + step * width])
        for k in range(len(line)):
            left, corner = (line[k - step], above[k - step]) if k >= step else (0, 0)
            if kind == 1:
                line[k] = (line[k] + left) & 255
            elif kind == 2:
                line[k] = (line[k] + above[k]) & 255
            elif kind == 3:
                line[k] = (line[k] + (left + above[k]) // 2) & 255
            elif kind == 4:
                p = left + above[k] - corner
                a, b, c = abs(p - left), abs(p - above[k]), abs(p - corner)
                line[k] = (line[k] + (left if a <= b and a <= c else above[k] if b <= c else corner)) & 255
        rows.append([tuple(line[k:k + 3]) for k in range(0, step * width, step)])
        above = line
    return rows
