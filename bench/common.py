# SPDX-License-Identifier: Apache-2.0
"""What the scripts of this folder share: where things are, and which machine this is."""
import datetime
import os
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILDS = [ROOT / "build-bench", ROOT / "build"]  # of bench/speed.py, and of ./check


def built(program):
    """The path of a benchmark program, or of brume, in the first build that has it."""
    for build in BUILDS:
        for path in (build / "bench" / program, build / program):
            if path.exists():
                return path
    sys.exit(f"{program} is not built: bench/speed.py and ./check do so")


def processor():
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def machine():
    """The machine and the moment, as figures are kept with them."""
    version = subprocess.run([built("brume"), "--version"], check=True, stdout=subprocess.PIPE,
                             text=True).stdout.splitlines()[0]
    now = datetime.datetime.now(datetime.timezone.utc)
    return {"processor": processor(), "processors": os.cpu_count(),
            "load": round(os.getloadavg()[0], 1), "brume": version.removeprefix("brume "),
            "date": now.strftime("%Y-%m-%d %H:%M UTC")}


def machine_line(of):
    """The same in words."""
    return (f"{of['processor']}, {of['processors']} processors, load average {of['load']:.1f}; "
            f"brume {of['brume']}, {of['date']}")
