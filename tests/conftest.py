"""Settings for all tests: a busy machine makes no property false, so no example has a deadline."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("varishold", deadline=None)
settings.load_profile("varishold")
