"""The C kernel is compiled into wheels and editable installs; where there is no C compiler, by one from pip.

The variable VARISHOLD_PLATFORM, a platform of `native/build.py`, makes the wheel of that platform.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class KernelHook(BuildHookInterface):
    """Compiles the kernel, and makes the wheel one of this platform."""

    def _native(self) -> Any:
        spec = importlib.util.spec_from_file_location("native_build", Path(self.root) / "native" / "build.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module

    def dependencies(self) -> list[str]:
        if self.target_name != "wheel":
            return []
        is_own = "VARISHOLD_PLATFORM" not in os.environ and self._native().system_compiler() is not None
        return [] if is_own else ["ziglang"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if self.target_name != "wheel":
            return
        native, platform = self._native(), os.environ.get("VARISHOLD_PLATFORM")
        if platform is None:
            platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
            for library in native.build():
                build_data["artifacts"].append(f"/{library.relative_to(self.root).as_posix()}")
        elif platform in native.PLATFORMS:
            for library in native.build(native.PLATFORMS[platform], Path(self.root) / "build" / platform):
                build_data["force_include"][str(library)] = f"varishold/kernel/{library.name}"
        else:
            sys.exit(f"VARISHOLD_PLATFORM: {platform} is none of {', '.join(native.PLATFORMS)}")
        build_data["pure_python"] = False
        # It is called by its C interface: one wheel serves every Python of a platform.
        build_data["tag"] = f"py3-none-{platform}"
