#!python
"""The command `sheaf` of the Python package: replaces itself by the program in the package."""

import importlib.util
import os
import sys

# Importing the package would load the module in C++, which the program does not need.
PACKAGE = importlib.util.find_spec("sheaf").submodule_search_locations[0]
os.execv(os.path.join(PACKAGE, "bin", "sheaf"), ["sheaf", *sys.argv[1:]])
