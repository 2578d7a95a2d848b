"""A headless Chromium, driven over its DevTools protocol with `websockets` alone."""

from __future__ import annotations

import base64
import itertools
import json
import shutil
import subprocess
import tempfile
import time
import urllib.request
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

__all__ = ["Chromium", "chromium_program"]

_START_S, _ANSWER_S = 60.0, 60.0


def chromium_program() -> str | None:
    """Return where the system's Chromium is, or None."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Chromium:
    """One page of a headless browser.

    Parameters
    ----------
    width, height : int
        Of its window, CSS pixels.
    dark : bool
        Whether the system is said to be dark.
    scale : float
        Pixels to a CSS pixel.
    """

    def __init__(self, width: int = 1240, height: int = 900, *, dark: bool = False, scale: float = 1.0) -> None:
        self._size = width, height, scale
        self._dark = dark
        self._folder = tempfile.TemporaryDirectory(prefix="chromium-", ignore_cleanup_errors=True)
        self._numbers = itertools.count(1)
        self._held = ExitStack()
        self.problems: list[str] = []

    def __enter__(self) -> Chromium:
        program = chromium_program()
        assert program is not None
        self._process = subprocess.Popen(
            [
                program,
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--no-first-run",
                "--disable-extensions",
                "--disable-dev-shm-usage",
                "--remote-debugging-port=0",
                f"--user-data-dir={self._folder.name}",
                "about:blank",
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self._socket = self._connected()
        width, height, scale = self._size
        self.call("Page.enable")
        self.call("Runtime.enable")
        self.call("Log.enable")
        metrics = {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": width < 700}
        self.call("Emulation.setDeviceMetricsOverride", **metrics)
        theme = {"name": "prefers-color-scheme", "value": "dark" if self._dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[theme])
        return self

    def __exit__(self, *_: object) -> None:
        self._held.close()
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._folder.cleanup()

    @property
    def pid(self) -> int:
        """The browser's process; those that draw are its children."""
        return self._process.pid

    def call(self, method: str, **given: Any) -> dict[str, Any]:
        """Call the browser; return its result."""
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": given}))
        ends = time.monotonic() + _ANSWER_S
        while True:
            told = json.loads(self._socket.recv(timeout=max(ends - time.monotonic(), 0.0)))
            if told.get("id") == number:
                if "error" in told:
                    raise RuntimeError(f"{method}: {told['error']['message']}")
                result: dict[str, Any] = told["result"]
                return result
            self._note(told)

    def open(self, address: str) -> None:
        """Go to an address, and wait until its page is there."""
        self.call("Page.navigate", url=address)
        self.wait(f"location.href === {json.dumps(address)} && document.readyState === 'complete'")

    def value(self, expression: str) -> Any:
        """Return what JavaScript says."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"].get("exception", {}).get("description", "exception"))
        return result["result"].get("value")

    def wait(self, expression: str, limit_s: float = 60.0) -> Any:
        """Wait until JavaScript says something true; return it."""
        ends = time.monotonic() + limit_s
        while not (told := self.value(expression)):
            if time.monotonic() > ends:
                raise TimeoutError(f"waited in vain for {expression}; the page shows: {self.value(_TEXT)}")
            time.sleep(0.02)
        return told

    def press(self, key: str) -> None:
        """Press a key."""
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, **(text if kind == "keyDown" else {}))

    def picture(self, path: Path, *, whole: bool = True) -> None:
        """Write a PNG of the page, whole or what is seen of it."""
        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(shot["data"]))

    def _connected(self) -> ClientConnection:
        port_file, ends = Path(self._folder.name, "DevToolsActivePort"), time.monotonic() + _START_S
        while not (port_file.exists() and port_file.read_text().strip()):
            if self._process.poll() is not None or time.monotonic() > ends:
                raise RuntimeError("Chromium did not start")
            time.sleep(0.05)
        port = port_file.read_text().split()[0]
        while time.monotonic() < ends:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list", timeout=30) as answer:
                pages = [one for one in json.load(answer) if one["type"] == "page"]
            if pages:
                address = pages[0]["webSocketDebuggerUrl"]
                return self._held.enter_context(connect(address, max_size=None, compression=None))
            time.sleep(0.05)
        raise RuntimeError("Chromium has no page")

    def _note(self, told: dict[str, Any]) -> None:
        """Keep what went wrong on the page."""
        if told.get("method") == "Runtime.exceptionThrown":
            details = told["params"]["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description", details["text"]))
        elif told.get("method") == "Log.entryAdded" and told["params"]["entry"]["level"] == "error":
            self.problems.append(told["params"]["entry"]["text"])


_TEXT = "document.body ? document.body.innerText.slice(0, 400) : ''"
