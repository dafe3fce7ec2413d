"""Headless Chromium by its DevTools protocol: pages, trusted events of pens, screenshots."""

from __future__ import annotations

import base64
import functools
import http.server
import json
import os
import shutil
import subprocess
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

__all__ = ["Browser", "browser_path", "opened", "served"]

_WAIT_S = 120.0


def browser_path() -> str | None:
    """Chromium or Chrome, where one is installed."""
    names = ("chromium", "chromium-browser", "google-chrome", "chrome")
    return next(filter(None, map(shutil.which, names)), None)


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        pass


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address of a folder that a plain web server hands out."""
    handler = functools.partial(_Quiet, directory=os.fspath(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


class Browser:
    """One page of a browser."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._number = 0
        self.heard: list[dict[str, Any]] = []

    def call(self, method: str, **words: Any) -> dict[str, Any]:
        """Ask for something, and wait for the answer."""
        self._number += 1
        asked = {"id": self._number, "method": method, "params": words}
        self._socket.send(json.dumps(asked))
        while True:
            answer: dict[str, Any] = json.loads(self._socket.recv(timeout=_WAIT_S))
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                result: dict[str, Any] = answer["result"]
                return result
            self.heard.append(answer)

    def evaluate(self, script: str) -> Any:
        """The value of an expression, or of its promise."""
        answer = self.call(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def wait_for(self, script: str) -> None:
        """Wait until an expression, which may `await`, is true."""
        until = time.monotonic() + _WAIT_S
        while not self.evaluate(f"(async () => Boolean({script}))()"):
            assert time.monotonic() < until, f"{script}: {self.complaints()}"
            time.sleep(0.05)

    def complaints(self) -> list[str]:
        """Errors on the page's console, and exceptions that it did not catch."""
        self.evaluate("0")
        said = []
        for one in self.heard:
            words = one.get("params", {})
            if one.get("method") == "Runtime.exceptionThrown":
                said.append(json.dumps(words["exceptionDetails"])[:600])
            elif one.get("method") == "Runtime.consoleAPICalled" and words["type"] == "error":
                said.append(json.dumps(words["args"])[:600])
            elif one.get("method") == "Log.entryAdded" and words["entry"]["level"] == "error":
                said.append(words["entry"]["text"])
        return said

    def screenshot(self, path: Path) -> None:
        """Keep what is seen, as PNG."""
        data = self.call("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))

    def call_all(self, asked: list[tuple[str, dict[str, Any]]]) -> None:
        """Ask for several things at once, and wait for all answers."""
        waiting = set()
        for method, words in asked:
            self._number += 1
            waiting.add(self._number)
            line = {"id": self._number, "method": method, "params": words}
            self._socket.send(json.dumps(line))
        while waiting:
            answer = json.loads(self._socket.recv(timeout=_WAIT_S))
            assert "error" not in answer, answer
            waiting.discard(answer.get("id"))
            if "id" not in answer:
                self.heard.append(answer)

    def stroke(
        self, way: list[tuple[float, float, float]], *, lifts: bool = True, **words: Any
    ) -> None:
        """Press a pen, move it along points (x, y) with forces, and lift it."""
        pointer = {"pointerType": "pen", "button": "left", "buttons": 1, "clickCount": 1} | words
        kinds = ["mousePressed", *["mouseMoved"] * (len(way) - 1)]
        asked = [
            ("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, "force": force, **pointer})
            for kind, (x, y, force) in zip(kinds, way, strict=True)
        ]
        lifted = {**asked[-1][1], "type": "mouseReleased", "force": 0.0, "buttons": 0}
        self.call_all([*asked, *([("Input.dispatchMouseEvent", lifted)] if lifts else [])])


@contextmanager
def opened(
    url: str, profile: Path, size: tuple[int, int] = (1280, 900), *flags: str
) -> Iterator[Browser]:
    """A browser without a window, with one page."""
    path = browser_path()
    assert path is not None, "there is a browser"
    words = [
        path, "--headless=new", "--no-sandbox", "--remote-debugging-port=0", "--no-first-run",
        "--disable-dev-shm-usage", "--enable-unsafe-swiftshader", "--hide-scrollbars",
        f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}", *flags, "about:blank",
    ]  # fmt: skip
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as run:
        try:
            port = _port_in(profile / "DevToolsActivePort", run)
            with connect(_page_at(port), max_size=1 << 28, open_timeout=_WAIT_S) as socket:
                browser = Browser(socket)
                for domain in ("Runtime", "Log", "Page"):
                    browser.call(f"{domain}.enable")
                browser.call(
                    "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1],
                    deviceScaleFactor=1, mobile=False,
                )  # fmt: skip
                browser.call("Page.navigate", url=url)
                yield browser
        finally:
            run.terminate()


def _port_in(path: Path, run: subprocess.Popen[bytes]) -> int:
    until = time.monotonic() + _WAIT_S
    while time.monotonic() < until:
        assert run.poll() is None, "the browser has ended"
        if path.is_file() and path.read_text().strip():
            return int(path.read_text().split()[0])
        time.sleep(0.05)
    raise AssertionError("the browser said no port")


def _page_at(port: int) -> str:
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/json", timeout=_WAIT_S) as answer:
        pages = json.load(answer)
    return next(one["webSocketDebuggerUrl"] for one in pages if one["type"] == "page")
