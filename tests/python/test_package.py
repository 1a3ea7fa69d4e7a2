"""The package itself: choice of the module by instruction set, wheels, and documentation."""

import base64
import hashlib
import importlib.metadata
import os
import re
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path
from unittest import mock

import scenes
import sheaf
import sheaf._native as _native


class Levels(unittest.TestCase):
    """The module of a wheel with two builds."""

    def choose(self, instructions, wanted="", levels=("x86-64-v3", "x86-64-v4")):
        with tempfile.TemporaryDirectory() as folder:
            for level in levels:
                (Path(folder) / "lib" / "sheaf" / level).mkdir(parents=True)
            with mock.patch.object(_native, "__file__", f"{folder}/_native.py"), \
                 mock.patch.object(_native, "_instructions", lambda: instructions), \
                 mock.patch.dict(os.environ, {"SHEAF_ISA": wanted}):
                return _native._folder().name

    def test_best(self):
        v3, v4 = _native.LEVELS["x86-64-v3"], _native.LEVELS["x86-64-v4"]
        self.assertEqual(self.choose(v4 | {"sse2"}), "x86-64-v4")
        self.assertEqual(self.choose(v4 - {"avx512dq"}), "x86-64-v3")
        self.assertEqual(self.choose(v4, "x86-64-v3"), "x86-64-v3")
        for instructions, wanted, message in ((v3, "x86-64-v4", "lacks the required instructions of x86-64-v4"),
                                              ({"sse2"}, "", "lacks the required instructions of x86-64-v3"),
                                              (v4, "avx2", "SHEAF_ISA is 'avx2': expected x86-64-v4, x86-64-v3")):
            with self.assertRaisesRegex(ImportError, message):
                self.choose(instructions, wanted)
        self.assertIn("sse2", _native._instructions())

    def test_one_build(self):
        """A module for one instruction set: that of the build folder, or of an installed package."""
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(_native, "__file__", f"{folder}/_native.py"):
            self.assertEqual(_native._folder(), Path(folder))
            shipped = Path(folder) / "lib" / "sheaf"
            shipped.mkdir(parents=True)
            self.assertEqual(_native._folder(), shipped)

    def test_incomplete_package(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(_native, "__file__", f"{folder}/_native.py"):
            with self.assertRaisesRegex(ImportError, "no _sheaf"):
                _native._load()


class Wheels(unittest.TestCase):
    def test_wheel(self):
        """A packed wheel can be imported, and lists all files with their checksums."""
        with tempfile.TemporaryDirectory() as folder:
            contents = Path(folder) / "contents" / "sheaf"
            contents.mkdir(parents=True)
            package = Path(sheaf.__file__).parent
            for file in package.glob("*.py*"):
                if file.is_file():
                    (contents / file.name).write_bytes(file.read_bytes())
            (contents / "_sheaf.so").write_bytes(b"module")
            packaging = scenes.ROOT / "tools/packaging"
            command = [sys.executable, packaging / "pack_wheel.py", contents.parent, folder]
            default = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
            self.assertRegex(Path(default).name, r"^sheaf-[0-9.]+-cp3\d+-cp3\d+-linux_x86_64\.whl$")
            done = subprocess.run([*command, "--tag", "cp313-cp313-manylinux_2_36_x86_64", "--script",
                                   packaging / "sheaf_script.py"], check=True, capture_output=True, text=True)
            wheel = done.stdout.strip()
            self.assertRegex(Path(wheel).name, r"^sheaf-[0-9.]+-cp313-cp313-manylinux_2_36_x86_64\.whl$")
            found = next(iter(importlib.metadata.distributions(name="sheaf", path=[wheel])))
            self.assertEqual((found.metadata["Name"], found.version), ("sheaf", sheaf.__version__))
            self.assertEqual(found.requires, ["numpy>=1.20"])
            listed = {str(file): file for file in found.files}
            with zipfile.ZipFile(wheel) as archive:
                self.assertEqual(set(archive.namelist()), set(listed))
                script = archive.getinfo(f"sheaf-{sheaf.__version__}.data/scripts/sheaf")
                self.assertEqual(script.external_attr >> 16, 0o100755)
                self.assertTrue(archive.read(script).startswith(b"#!python\n"))
                for name in archive.namelist():
                    if not name.endswith("RECORD"):
                        digest = base64.urlsafe_b64encode(hashlib.sha256(archive.read(name)).digest()).rstrip(b"=")
                        self.assertEqual(listed[name].hash.value, digest.decode())


class Documentation(unittest.TestCase):
    def test_snippets(self):
        """Every block of Python in docs/python.md and README.md runs, from top to bottom."""
        for page in ("docs/python.md", "README.md"):
            text = (scenes.ROOT / page).read_text(encoding="utf-8")
            blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
            self.assertTrue(blocks)
            for block in blocks:
                block = re.sub(r"spp=\d+", "spp=1, size=(32, 24)", block)
                block = re.sub(r'"(scenes/[^"]*)"', lambda m: repr(str(scenes.ROOT / m[1])), block)
                with tempfile.TemporaryDirectory() as folder, self.subTest(page=page, block=block):
                    before = os.getcwd()
                    os.chdir(folder)
                    try:
                        exec(compile(block, page, "exec"), {})
                    finally:
                        os.chdir(before)

    def test_docstrings(self):
        """Everything public has a docstring, and docs/python.md names it."""
        text = (scenes.ROOT / "docs" / "python.md").read_text(encoding="utf-8")
        for name in sheaf.__all__:
            self.assertTrue(getattr(sheaf, name).__doc__, name)
            self.assertRegex(text, rf"\b{name}\b")


if __name__ == "__main__":
    unittest.main()
