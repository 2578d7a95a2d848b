"""Take the picture of the live page, docs/images/live_page.png: python docs/images/live_page.py (needs Chromium)."""

from __future__ import annotations

import time
from pathlib import Path

from benchmarks._chromium import Chromium
from varishold.live import source_at
from varishold.live.server import PageServer
from varishold.live.session import Session

SKIN = "sim:cone-frustum?seed=11"
HELD_S = 0.8


def main() -> None:
    """Watch a simulated skin until a contact has been seen for a while."""
    with Session(source_at(SKIN)) as session, PageServer(session, port=0) as server, Chromium(1240, 1270) as browser:
        browser.open(server.address)
        while session.newest is None or not any(
            track.seen_s - track.onset_s > HELD_S for pad in session.newest.pads.values() for track in pad.tracks
        ):
            time.sleep(0.01)
        time.sleep(0.5)
        browser.picture(Path(__file__).with_suffix(".png"), whole=False)


if __name__ == "__main__":
    main()
