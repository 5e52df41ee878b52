#!/usr/bin/env python3
"""Sets Planetfall up and runs it; needs nothing but a Python.

    python3 run.py [options]        the demo (options: python3 run.py --help)
    python3 run.py test [options]   linter, type checker and tests: enough to trust the installation; with --all every
                                    test but the slow ones, with --slow these too (options go to pytest)

Makes .venv beside this file and installs the package into it; on Debian, Ubuntu and the like it also installs the
system libraries that are missing. The next start finds all that done and takes no time.
"""

# Standard library only. The syntax is kept old, so that an old Python can still start a newer one.

import ctypes
import glob
import hashlib
import json
import os
import shutil
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.abspath(__file__))
VENV = os.path.join(ROOT, ".venv")
STAMP = os.path.join(VENV, "planetfall-stamp.json")
FOLDERS = ("engine", "components", "systems", "games", "benchmarks")  # they install inside planetfall/
OLDEST = (3, 11)
NEWEST_TRIED = 16

# What the package needs, by the name of the library or program -> Debian package.
LIBRARIES = {"libEGL.so.1": "libegl1", "libGL.so.1": "libgl1", "libfontconfig.so.1": "libfontconfig1"}
TEST_PROGRAMS = {
    "Xvfb": "xvfb",
    "xauth": "xauth",
    "glslangValidator": "glslang-tools",
    "spirv-val": "spirv-tools",
}
# Half of a test is one thread of Python or of a shader's compiler.
TWO_AT_ONCE = ["-n", "auto", "--maxprocesses", "2", "--dist", "loadfile"]
OTHER_SYSTEMS = "Fedora: dnf install mesa-libEGL mesa-libGL fontconfig; Arch: pacman -S mesa fontconfig"


class SetupError(Exception):
    """Nothing went wrong in the program: something is missing on this machine. The message says what to do."""


def say(text):
    print("run.py: " + text, flush=True)


def main(arguments):
    testing = arguments[:1] == ["test"]
    if arguments[:1] in (["-h"], ["--help"]):
        return show_help()
    try:
        refuse_macos()
        python = ready_environment(testing)
        if testing:
            return run_tests(python, arguments[1:])
        return subprocess.call([python, "-m", "planetfall.games.demo_planet", *arguments], env=environment())
    except SetupError as error:
        print("run.py: " + str(error), file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


def show_help():
    """Installs nothing: the demo adds its own options once it is set up."""
    print(__doc__.strip() + "\n", flush=True)
    python = venv_python()
    if not (os.path.exists(python) and read_stamp_covers(wanted_stamp(False))):
        say("the demo's own options can be listed once it is set up: start it once, then ask for --help again")
        return 0
    say("options of the demo:")
    return subprocess.call([python, "-m", "planetfall.games.demo_planet", "--help"], env=environment())


def refuse_macos():
    if sys.platform == "darwin":
        raise SetupError(
            "Planetfall needs OpenGL 4.3; macOS stops at OpenGL 4.1, so it cannot run here. "
            "Use Linux or Windows, or a Linux container (software rendering works without a GPU)."
        )


# the environment


def ready_environment(testing):
    """Path of .venv's Python with the package installed; installs what is missing."""
    system_libraries(testing)
    python = venv_python()
    wanted = wanted_stamp(testing)
    if os.path.exists(python) and read_stamp_covers(wanted):
        return python
    if not works(python):
        make_venv()
    install(python, testing)
    write_stamp(wanted)
    return python


def venv_python():
    return os.path.join(VENV, "Scripts", "python.exe") if os.name == "nt" else os.path.join(VENV, "bin", "python")


def wanted_stamp(testing):
    """What the environment must have been made from: a change of it means to install again."""
    digest = hashlib.sha256()
    for name in ("pyproject.toml", os.path.join("planetfall", "_version.py")):
        with open(os.path.join(ROOT, name), "rb") as file:
            digest.update(file.read())
    return {"made_from": digest.hexdigest(), "root": ROOT, "test": bool(testing)}


def read_stamp_covers(wanted):
    try:
        with open(STAMP, encoding="utf-8") as file:
            found = json.load(file)
    except (OSError, ValueError):
        return False
    same = found.get("made_from") == wanted["made_from"] and found.get("root") == wanted["root"]
    return same and (found.get("test") or not wanted["test"])


def write_stamp(wanted):
    beside = STAMP + ".part"
    with open(beside, "w", encoding="utf-8") as file:
        json.dump(wanted, file)
    os.replace(beside, STAMP)


def works(python):
    """Whether this Python of a virtual environment is new enough and has pip."""
    return version_of([python], "pip") >= OLDEST


def version_of(python, module="venv"):
    """(major, minor) of a Python command; (0, 0) when it does not run or has no such module."""
    code = f"import sys, {module}; print(*sys.version_info[:2])"
    try:
        answer = subprocess.check_output([*python, "-c", code], stderr=subprocess.DEVNULL, timeout=60)
    except (OSError, subprocess.SubprocessError):
        return (0, 0)
    return tuple(int(part) for part in answer.decode().split())


def find_python():
    """The command of a Python >= 3.11: this one if it will do, else the newest one around."""
    if sys.version_info[:2] >= OLDEST:
        return [sys.executable]
    for minor in range(NEWEST_TRIED, OLDEST[1] - 1, -1):
        for command in [f"python3.{minor}"], ["py", f"-3.{minor}"]:
            if shutil.which(command[0]) and version_of(command) >= OLDEST:
                return command
    raise SetupError(
        f"Planetfall needs Python 3.11 or newer; this is {'.'.join(map(str, sys.version_info[:2]))} "
        f"({sys.executable}) and no newer one was found. {python_remedy()}"
    )


def python_remedy():
    if os.name == "nt":
        return "Install one from https://www.python.org/downloads/ and start run.py again."
    if shutil.which("apt-get"):
        return "Try: apt-get install python3.11 python3.11-venv (or a newer one), then start run.py again."
    return "Install one with your system's package manager, then start run.py again."


def make_venv():
    python = find_python()
    if os.path.isdir(VENV):
        say(".venv does not work (moved, or made by a Python that is gone); making it anew")
        shutil.rmtree(VENV)
    say("making .venv")
    if subprocess.call([*python, "-m", "venv", VENV]) == 0:
        return
    shutil.rmtree(VENV, ignore_errors=True)
    if shutil.which("apt-get"):  # Debian keeps ensurepip in a package of its own
        major, minor = version_of(python)
        apt_install([f"python{major}.{minor}-venv"], "Python's venv is not complete")
        if subprocess.call([*python, "-m", "venv", VENV]) == 0:
            return
        shutil.rmtree(VENV, ignore_errors=True)
    raise SetupError("the virtual environment could not be made; the reason is above")


def install(python, testing):
    extras = "dev" if testing else "video"
    say("installing Planetfall and what it needs into .venv (once; some minutes on a slow line)")
    command = [python, "-m", "pip", "install", "--disable-pip-version-check", "-q", "-e", f".[{extras}]"]
    code = subprocess.call(command, cwd=ROOT, env=environment())
    if code == 0:
        return
    raise SetupError(
        "pip could not install the packages (its message is above). If this machine is offline, go online once, or set "
        "PIP_INDEX_URL or PIP_FIND_LINKS to a mirror or a folder of wheels; then start run.py again.\n"
        f"        the command was: cd {ROOT} && {' '.join(command)}"
    )


def environment():
    variables = dict(os.environ)
    # A PYTHONHOME or PYTHONPATH of another installation would shadow .venv.
    variables.pop("PYTHONHOME", None)
    variables.pop("PYTHONPATH", None)
    return variables


# system libraries


def system_libraries(testing):
    if not sys.platform.startswith("linux"):
        return
    missing = {name: package for name, package in LIBRARIES.items() if not present(name)}
    if testing:
        missing.update({name: package for name, package in TEST_PROGRAMS.items() if not present(name)})
    if not missing:
        return
    names = ", ".join(sorted(missing))
    if not shutil.which("apt-get"):
        say(f"missing: {names} ({OTHER_SYSTEMS}); going on without")
        return
    try:
        apt_install(sorted(set(missing.values())), f"missing: {names}")
    except SetupError as error:
        if testing or "libEGL.so.1" in missing or "libGL.so.1" in missing:
            raise
        say(f"{error}; going on without")  # fonts only: some text in pyglet windows
        return
    still = sorted(name for name in missing if not present(name))
    if still:
        raise SetupError(f"still missing after the installation: {', '.join(still)}")


def present(name):
    """Whether a shared library loads, or a program is on the PATH."""
    if ".so" not in name:
        return shutil.which(name) is not None
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def apt_install(packages, why):
    """Install Debian packages as root or with sudo; else raise a SetupError that says exactly what to type."""
    by_hand = "apt-get update && apt-get install -y --no-install-recommends " + " ".join(packages)
    prefix = become_root()
    if prefix is None:
        raise SetupError(f"{why}. As root, run: {by_hand}")
    say(f"{why}; installing {' '.join(packages)}")
    # Through env, because sudo does not pass variables on.
    apt = [*prefix, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq", "-o", "Dpkg::Use-Pty=0"]
    install_command = [*apt, "install", "-y", "--no-install-recommends", *packages]
    if glob.glob("/var/lib/apt/lists/*_Packages*") and subprocess.call(install_command) == 0:
        return
    subprocess.call([*apt, "update"])
    if subprocess.call(install_command) != 0:
        raise SetupError(f"{why}, and apt-get could not install it (its message is above). As root, run: {by_hand}")


def become_root():
    """What to put before a command to run it as root: nothing, sudo, or None when there is no way."""
    if os.geteuid() == 0:
        return []
    sudo = shutil.which("sudo")
    if not sudo:
        return None
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    asks_password = subprocess.call([sudo, "-n", "true"], **quiet) != 0
    return None if asks_password and not sys.stdin.isatty() else [sudo]


# the tests


def run_tests(python, arguments):
    """Linter, type checker, tests: all of them, even after a failure; then a line for each. 0 when all are well."""
    steps = [
        ("ruff", lambda: call([python, "-m", "ruff", "check", "."])),
        ("basedpyright", lambda: check_types(python)),
        ("pytest", lambda: call([python, "-m", "pytest", *TWO_AT_ONCE, *arguments])),
    ]
    results = []
    for name, step in steps:
        say(f"{name} ...")
        started = time.time()
        results.append((name, step(), time.time() - started))
    print("", flush=True)
    for name, code, seconds in results:
        say(f"{name:14} {'ok' if code == 0 else 'FAILED':7} {seconds:6.1f} s")
    spent = os.times()
    if os.name != "nt":  # Windows does not say
        say(f"processor time  {spent.children_user + spent.children_system:6.0f} s")
    if not {"--all", "--slow"} & set(arguments):
        say("python3 run.py test --all runs every test but the slow ones, --slow these too")
    return 0 if all(code == 0 for _, code, _ in results) else 1


def call(command):
    return subprocess.call(command, cwd=ROOT, env=environment())


def check_types(python):
    """basedpyright over the library as it is installed: one package with engine, systems ... inside.

    A checkout becomes that at run time only (planetfall/__init__.py), which no type checker can follow. So the sources
    are copied into that shape, and the messages are turned back to name the real files.
    """
    shape = os.path.join(ROOT, "build", "types")
    package = os.path.join(shape, "planetfall")
    shutil.rmtree(shape, ignore_errors=True)
    only_python = shutil.ignore_patterns("__pycache__", "*.pyc")
    shutil.copytree(os.path.join(ROOT, "planetfall"), package, ignore=only_python)
    for folder in FOLDERS:
        shutil.copytree(os.path.join(ROOT, folder), os.path.join(package, folder), ignore=only_python)
    shutil.copy(os.path.join(ROOT, "pyproject.toml"), shape)
    command = [python, "-m", "basedpyright", "--pythonpath", python]
    found = subprocess.run(command, check=False, cwd=shape, env=environment(), capture_output=True)
    text = found.stdout.decode("utf-8", "replace")
    # The settings name .venv for editors; here --pythonpath says it.
    complaints = [line for line in found.stderr.decode("utf-8", "replace").splitlines() if "venv path" not in line]
    print("\n".join(complaints), file=sys.stderr, end="\n" if complaints else "")
    for folder in FOLDERS:
        text = text.replace(os.path.join(package, folder), os.path.join(ROOT, folder))
    print(text.replace(package, os.path.join(ROOT, "planetfall")).rstrip(), flush=True)
    return found.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
