#!/usr/bin/python3
"""Runs the cases from public bug reports in the shared data: field_files.py TREPHINE DATA. Exit code 77: no data."""
import os
import subprocess
import sys


def wrong_cases(script, binary):
    """Returns the lines of the wrong cases, and whether the script ran to its end."""
    out = subprocess.run([sys.executable, script, binary], capture_output=True, text=True).stdout
    lines = [line for line in out.splitlines() if line.startswith("WRONG")]
    return lines, out.rstrip().endswith(f"{len(lines)} wrong")


binary, data = sys.argv[1], os.environ.get("TREPHINE_DATA", sys.argv[2])
script = os.path.join(data, "field_cases", "check.py")
if not os.path.exists(script):
    print("no real data: set TREPHINE_DATA")
    sys.exit(77)
lines, is_complete = wrong_cases(script, binary)
print("\n".join(lines) or "no case is wrong")
# Planted fault: most cases must be wrong for a command without output.
planted, _ = wrong_cases(script, "/bin/false")
sys.exit(not is_complete or bool(lines) or len(planted) < 40)
