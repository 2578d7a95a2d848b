"""Make the moving picture of the live page, docs/images/live.gif: python docs/images/live.py (needs Chromium)."""

from __future__ import annotations

import tempfile
import time
from itertools import pairwise
from pathlib import Path

from PIL import Image

from benchmarks._chromium import Chromium
from varishold.live import source_at
from varishold.live.server import PageServer
from varishold.live.session import Session

SKIN = "sim:cone-frustum?seed=11"
LASTS_S, STEP_S, WIDTH = 9.0, 0.16, 720
#: The frame, the outlines, the answer; what stands below moves less.
SEEN = (1240, 760)


def main() -> None:
    """Take a picture every so often, while a simulated skin is pressed."""
    with (
        Session(source_at(SKIN)) as session,
        PageServer(session, port=0) as server,
        Chromium(*SEEN) as browser,
        tempfile.TemporaryDirectory() as folder,
    ):
        browser.open(server.address)
        while session.newest is None or not any(pad.tracks for pad in session.newest.pads.values()):
            time.sleep(0.01)
        begun, taken = time.monotonic(), []
        while time.monotonic() - begun < LASTS_S:
            path = Path(folder, f"{len(taken)}.png")
            browser.picture(path, whole=False)
            taken.append((time.monotonic(), path))
            time.sleep(max(0.0, begun + STEP_S * len(taken) - time.monotonic()))
        height = round(WIDTH * SEEN[1] / SEEN[0])
        pictures = [
            Image.open(path).convert("RGB").resize((WIDTH, height), Image.Resampling.LANCZOS) for _, path in taken
        ]
        # One palette for all, so that what stands still stays the same.
        sheet = Image.new("RGB", (WIDTH, height * 3))
        for k, picture in enumerate((pictures[0], pictures[len(pictures) // 2], pictures[-1])):
            sheet.paste(picture, (0, k * height))
        palette = sheet.quantize(96)
        frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
        times = [at for at, _ in taken]
        lasts_ms = [max(20, round(1e3 * (b - a))) for a, b in pairwise(times)] + [400]
        path = Path(__file__).with_suffix(".gif")
        frames[0].save(path, save_all=True, append_images=frames[1:], duration=lasts_ms, loop=0, optimize=True)
        print(f"{path}: {len(frames)} pictures, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
