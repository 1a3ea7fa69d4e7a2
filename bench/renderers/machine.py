"""Describes the machine and the programs of a measurement."""

import os
import platform
import re
from pathlib import Path

IDLE_LOAD = 0.3  # running processes


def read(path):
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def first(pattern, text, default="unknown"):
    found = re.search(pattern, text, re.MULTILINE)
    return found[1].strip() if found else default


def compiler(program):
    """The compilers that a program names in its .comment section. Clang's objects are linked with those of GCC."""
    data = Path(program).read_bytes()
    clang = re.search(rb"clang version [\d.]+", data)
    gcc = re.search(rb"GCC: \([^)]*\) [\d.]+", data)
    found = clang or gcc
    return found[0].decode() if found else "unknown compiler"


def describe(arguments, versions):
    """Returns [(what, description)]. `versions`: {program: version}."""
    cpu = read("/proc/cpuinfo")
    model = first(r"^model name\s*: (.*)$", cpu, platform.processor() or "unknown")
    isa = " with AVX-512" if " avx512f" in cpu else " with AVX2" if " avx2" in cpu else ""
    is_virtual = ", in a virtual machine" if re.search(r"^flags.* hypervisor", cpu, re.MULTILINE) else ""
    cache = first(r"^(\d+)K", read("/sys/devices/system/cpu/cpu0/cache/index2/size"), "")
    memory = int(first(r"^MemTotal:\s+(\d+)", read("/proc/meminfo"), "0")) * 1024 / 1e9
    system = first(r'^PRETTY_NAME="?([^"\n]*)', read("/etc/os-release"))
    return [
        ("processor", f"{model}{isa}, {os.cpu_count()} logical cores{is_virtual}"),
        ("memory", f"{memory:.0f} GB" + (f", L2 cache {int(cache) / 1024:g} MB per core" if cache else "")),
        ("system", f"{system}, Python {platform.python_version()}"),
        ("Sheaf", f"{versions['Sheaf']}, {compiler(arguments.sheaf)}"),
        *[(name, version) for name, version in versions.items() if name != "Sheaf"],
    ]


def describe_load(before, after):
    state = "idle" if before < IDLE_LOAD else "not idle"
    return f"{state}: {before:.1f} running processes before the measurement, {after:.1f} after it"


def load():
    """Running processes, on average over the last minute."""
    return os.getloadavg()[0]
