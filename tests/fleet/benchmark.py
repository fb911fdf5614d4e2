"""`tactbench benchmark fleet` against a PostgreSQL of its own, with fsync as on a real server.

    benchmark.py PROGRAM [ROUNDS]
"""

import sys
import tempfile

from server import Program, Server, skip_unless_possible

skip_unless_possible()
with tempfile.TemporaryDirectory(prefix="tactbench-fleet-") as folder, Server("fsync=on") as server:
    lab = Program(sys.argv[1], folder)
    server.new_database("tactile")
    lab.run("fleet", "migrate", "--to", server.conninfo())
    print(lab.run("benchmark", "fleet", "--to", server.conninfo(), "--rounds", *(sys.argv[2:] or ["5"])), end="")
