"""Loaded at the start of every Python that a test starts: the changed code runs there as it does in the test itself."""

import os

if os.environ.get("MUTANTS_CALLS"):
    import atexit

    from mutants.calls import Calls

    _calls = Calls(os.environ["MUTANTS_ROOT"])
    _calls.start()
    atexit.register(_calls.leave, os.environ["MUTANTS_CALLS"])
