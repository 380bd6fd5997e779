"""A headless Chromium that is driven through its DevTools protocol over a pipe: no port, no library."""

import base64
import json
import os
import shutil
import subprocess
import time
from contextlib import contextmanager

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SECONDS = 60  # for one answer


class Browser:
    """Commands go in as JSON with a zero byte behind, answers and events come out alike."""

    def __init__(self, commands, answers):
        self._commands, self._answers, self._number, self._rest = commands, answers, 0, b""
        self.events = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if hasattr(self, "_session"):
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while (answer := self._next()).get("id") != self._number:
            self.events.append(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']}")
        return answer["result"]

    def _next(self):
        while b"\0" not in self._rest:
            piece = os.read(self._answers, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has gone")
            self._rest += piece
        message, self._rest = self._rest.split(b"\0", 1)
        return json.loads(message)

    def show(self, path, width, height):
        """Open a file at a size in CSS pixels, and wait until it is there."""
        mobile = width < 600
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        self.events.clear()
        self.ask("Page.navigate", url=path.resolve().as_uri())
        deadline = time.monotonic() + SECONDS
        while not any(event["method"] == "Page.loadEventFired" for event in self.events):
            assert time.monotonic() < deadline, "the page does not load"
            self.value("1")

    def value(self, expression):
        """What an expression of the page is."""
        answer = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def complaints(self):
        """Exceptions and errors in the console since the page was opened."""
        kinds = ("Runtime.exceptionThrown", "Log.entryAdded")
        return [event for event in self.events if event["method"] in kinds] + [
            event
            for event in self.events
            if event["method"] == "Runtime.consoleAPICalled" and event["params"]["type"] in ("error", "warning")
        ]

    def drag(self, start, end):
        """The mouse pressed at one point (x, y) and let go at another."""
        for kind, (x, y) in (
            ("mouseMoved", start),
            ("mousePressed", start),
            ("mouseMoved", end),
            ("mouseReleased", end),
        ):
            held = 0 if (kind, x) == ("mouseMoved", start[0]) else 1
            self.ask(
                "Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left" if held else "none", buttons=held,
                clickCount=int(kind != "mouseMoved"),
            )  # fmt: skip

    def picture(self, path, whole=False):
        """A screenshot as a PNG file."""
        data = self.ask("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))

    def printed(self, path):
        """The page on A4 as a PDF file."""
        data = self.ask("Page.printToPDF", preferCSSPageSize=True, printBackground=True)["data"]
        path.write_bytes(base64.b64decode(data))


@contextmanager
def browser(folder):
    """A browser whose profile lies in a folder; it ends with the context."""
    to_read, to_write = os.pipe()
    out_read, out_write = os.pipe()

    command = [
        CHROMIUM,
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--no-first-run",
        "--remote-debugging-pipe",  # reads commands from descriptor 3 and writes answers to 4
        f"--user-data-dir={folder}",
    ]
    process = subprocess.Popen(
        ["sh", "-c", f'exec "$0" "$@" 3</dev/fd/{to_read} 4>/dev/fd/{out_write}', *command],
        pass_fds=(to_read, out_write),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(to_read)
    os.close(out_write)
    try:
        yield Browser(to_write, out_read)
    finally:
        process.terminate()
        process.wait(timeout=SECONDS)
        os.close(to_write)
        os.close(out_read)
