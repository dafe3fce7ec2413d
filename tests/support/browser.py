"""A headless Chromium for tests, driven over a pipe by its own protocol; no package is needed."""

from __future__ import annotations

import base64
import io
import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
from PIL import Image

PROGRAM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
OPTIONS = [
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-pipe",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--force-color-profile=srgb",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-gpu-sandbox",
]


class Browser:
    """One page; everything that it says or asks for over the network is kept."""

    def __init__(self, folder: Path) -> None:
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        start = f'exec "$0" "$@" 3<&{theirs_in} 4>&{theirs_out}'
        self._process = subprocess.Popen(
            ["bash", "-c", start, PROGRAM, *OPTIONS, f"--user-data-dir={folder}", "about:blank"],
            pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._rest = b""
        self._last = 0
        self._session = None
        self.requests: list[str] = []
        self.complaints: list[str] = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def close(self) -> None:
        """End the browser."""
        self._process.terminate()
        self._process.wait(timeout=300)
        os.close(self._in)
        os.close(self._out)

    def call(self, method: str, **parameters: object) -> dict:
        """Ask for something and wait for the answer."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read()
            if answer.get("id") == self._last:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _read(self) -> dict:
        while b"\0" not in self._rest:
            more = os.read(self._in, 1 << 20)
            assert more, "the browser has gone"
            self._rest += more
        text, self._rest = self._rest.split(b"\0", 1)
        return json.loads(text)

    def _note(self, event: dict) -> None:
        parameters = event.get("params", {})
        if event.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])
        elif event.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded"):
            self.complaints.append(json.dumps(parameters)[:500])

    def open(self, path: Path, fragment: str = "", size: tuple[int, int] = (640, 480)) -> None:
        """Open a file and wait until the page says that it is ready."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=size[0], height=size[1], deviceScaleFactor=1, mobile=False,
        )  # fmt: skip
        self.call("Page.navigate", url="about:blank")
        self.call("Page.navigate", url=f"{path.as_uri()}{fragment and '#' + fragment}")
        ready = "document.documentElement && document.documentElement.dataset.ready === 'true'"
        said = "document.getElementById('message') && !document.getElementById('message').hidden"
        self.evaluate(
            f"new Promise((done) => {{ const look = () => ({ready}) || ({said})"
            " ? done(true) : setTimeout(look, 20); look(); })"
        )

    def evaluate(self, expression: str) -> object:
        """Return the value of an expression in the page; promises are waited for."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def picture(self) -> np.ndarray:
        """Return what is on the screen, (H, W, 3) uint8."""
        self.evaluate(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )
        data = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))

    def mouse(self, kind: str, x: float, y: float, **more: object) -> None:
        """Send a mouse event: pressed, moved, released or wheel."""
        names = {"wheel": "mouseWheel"}
        self.call(
            "Input.dispatchMouseEvent",
            type=names.get(kind, f"mouse{kind.capitalize()}"), x=x, y=y, **more,
        )  # fmt: skip

    def drag(self, start: tuple[float, float], end: tuple[float, float], **more: object) -> None:
        """Press, move and release the left button."""
        held = {"button": "left", "buttons": 1, "clickCount": 1} | more
        self.mouse("pressed", *start, **held)
        self.mouse("moved", *end, **held)
        self.mouse("released", *end, **held)

    def key(self, key: str, **more: object) -> None:
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, **more)

    def touch(self, *steps: list[tuple[float, float]]) -> None:
        """Put fingers down, move them step by step, and lift them."""
        kinds = ["touchStart", *["touchMove"] * (len(steps) - 1)]
        for kind, points in zip(kinds, steps, strict=True):
            places = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(points)]
            self.call("Input.dispatchTouchEvent", type=kind, touchPoints=places)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
