"""What the tests of the Python module share: PROGRAM, the module, scenes, and runs of the program to compare with."""
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
PROGRAM, MODULE = map(os.path.abspath, sys.argv[1:3])
SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
SCENES = os.path.join(SOURCE, "sim", "scenes")
sys.path.append(os.path.join(SOURCE, "tests", "support"))


def skip(reason):
    print(f"tactus-skipped: {reason}")
    sys.exit(77)


if not os.path.exists(os.path.join(MODULE, "tactus")) or not any(
        name.startswith("_core") for name in os.listdir(os.path.join(MODULE, "tactus"))):
    skip("no Python module in this build (Debian: pybind11-dev, python3-dev)")
try:
    import numpy  # noqa: F401
except ImportError:
    skip("no NumPy (Debian: python3-numpy)")
sys.path.insert(0, MODULE)


def scene(name):
    return os.path.join(SCENES, name + ".toml")


def program(*arguments):
    """The program's JSON object; its status is not looked at."""
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}  # the module's sanitizer
    out = subprocess.run([PROGRAM, *map(str, arguments), "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                         env=environment, check=False).stdout
    return json.loads(out)


def run(name, seconds, *options):
    return program("run", scene(name), "--virtual-time", "--duration", seconds, *options)
