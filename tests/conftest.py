"""Settings for all tests: the same examples every time, and no deadline, for a busy machine makes no property false.

`pytest --hypothesis-profile=fresh` (`make laws`) draws new examples.
"""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("fresh", deadline=None, derandomize=False)
settings.load_profile("same")
