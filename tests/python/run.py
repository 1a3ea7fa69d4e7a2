#!/usr/bin/env python3
"""Runs the tests of the Python package in this folder, with the coverage of its lines if coverage.py is installed.

  tests/python/run.py --package build/release/python --sheaf build/release/sheaf [--report FILE] [NAME...]

--report: also writes the coverage to a file. NAME: only these tests, as unittest names them.
Exit status: 0 all passed, 1 something failed.
"""

import argparse
import io
import os
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent


def run(names):
    loader = unittest.TestLoader()
    suite = loader.loadTestsFromNames(names) if names else loader.discover(str(HERE), top_level_dir=str(HERE))
    return unittest.TextTestRunner(verbosity=1).run(suite).wasSuccessful()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--package", required=True)
    parser.add_argument("--sheaf", required=True)
    parser.add_argument("--report")
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    sys.path[:0] = [arguments.package, str(HERE)]
    os.environ["SHEAF_PROGRAM"] = arguments.sheaf
    try:
        import coverage
    except ImportError:
        print("coverage.py is not installed: the coverage is not measured")
        return 0 if run(arguments.names) else 1
    measured = coverage.Coverage(source=[str(ROOT / "tools/python/sheaf"), arguments.package + "/sheaf"], data_file=None)
    measured.start()
    passed = run(arguments.names)
    measured.stop()
    text = io.StringIO()
    measured.report(file=text)
    print(text.getvalue())
    if arguments.report:
        Path(arguments.report).write_text("Coverage of the Python package:\n" + text.getvalue(), encoding="utf-8")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
