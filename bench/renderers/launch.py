"""Runs a command and writes its start, wall time, CPU time and peak memory to a JSON file; run by programs.py.

  launch.py RESULT.json COMMAND...

This is a process of its own, because Linux counts the memory of the starting process as memory of the started one.
"""

import json
import os
import sys
import time


def main():
    result, *command = sys.argv[1:]
    start = time.time()
    process = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(process, 0)
    seconds = time.time() - start
    with open(result, "w", encoding="utf-8") as file:
        json.dump({"start": start, "seconds": seconds, "cpu_seconds": usage.ru_utime + usage.ru_stime,
                   "peak_bytes": usage.ru_maxrss * 1024}, file)
    code = os.waitstatus_to_exitcode(status)
    sys.exit(code if code >= 0 else 128 - code)


if __name__ == "__main__":
    main()
