"""Loads the module in C++. Wheels contain one for each of several instruction sets, in folders of their names."""

import importlib.util
import os
import sys
from pathlib import Path

# Instructions by level of the x86-64 psABI, the best level first, with the names of /proc/cpuinfo.
LEVELS = {
    "x86-64-v4": {"avx2", "bmi1", "bmi2", "fma", "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": {"avx2", "bmi1", "bmi2", "fma"},
}


def _instructions() -> set:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            for line in lines:
                if line.startswith("flags"):
                    return set(line.split(":", 1)[1].split())
    except OSError:
        pass
    return set()


def _folder() -> Path:
    """The folder of the best module for this processor, or of the one that $SHEAF_ISA requests."""
    package = Path(__file__).parent
    shipped = package / "lib" / "sheaf"  # where the program looks as well
    builds = [level for level in LEVELS if (shipped / level).is_dir()]
    if not builds:
        return shipped if shipped.is_dir() else package
    wanted = os.environ.get("SHEAF_ISA", "")
    if wanted and wanted not in builds:
        raise ImportError(f"SHEAF_ISA is '{wanted}': expected {', '.join(builds)} or nothing")
    has = _instructions()
    for level in builds:
        if LEVELS[level] <= has and wanted in ("", level):
            return shipped / level
    raise ImportError("this processor lacks the required instructions of " + (wanted or builds[-1]))


def _load():
    found = _folder()
    files = sorted(found.glob("_sheaf*.so"))
    if not files:
        raise ImportError(f"the package is incomplete: no _sheaf*.so in '{found}'")
    spec = importlib.util.spec_from_file_location("sheaf._sheaf", files[0])
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


native = _load()
