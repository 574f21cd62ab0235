"""Runs a command and writes into a file what it took: FILE COMMAND...

The kernel counts the memory of a new process from that of the process that starts it. This one is small, so that the figure is the
command's own from about 10 MB on; the programs that compare are large.
"""

import os
import sys
import time

file, command = sys.argv[1], sys.argv[2:]
start = time.monotonic()
_, status, usage = os.wait4(os.posix_spawnp(command[0], command, os.environ), 0)
wall = time.monotonic() - start
# ru_maxrss is in KiB.
took = (os.waitstatus_to_exitcode(status), wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss << 10)
with open(file, "w") as out:
    out.write(" ".join(map(str, took)))
