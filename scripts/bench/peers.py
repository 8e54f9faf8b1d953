"""Other programs: their environment of Python packages, and the processes in which they wait for requests."""
import json
import pathlib
import shutil
import subprocess
import sys

from project import CACHE, ROOT

HERE = pathlib.Path(__file__).resolve().parent
LIST = HERE / "requirements-peers.txt"
ENVIRONMENT = ROOT / ".venv-peers"
PYTHON = ENVIRONMENT / "bin/python"
# Name of each peer, its package, the program in workers/ and its arguments.
PEERS = {
    "mitsuba llvm": ("mitsuba", ["mitsuba_worker.py", "llvm_ad_rgb"]),
    "mitsuba scalar": ("mitsuba", ["mitsuba_worker.py", "scalar_rgb"]),
    "cycles": ("bpy", ["cycles_worker.py"]),
    "embree": ("embreex", ["embree_worker.py"]),
}


class Failed(Exception):
    """A peer that has ended, with the last that it said."""


def say(text):
    print(f"bench: {text}", flush=True)


def install():
    """Installs what is missing; packages that cannot be had are left out, and named in a line each."""
    stamp = ENVIRONMENT / ".installed"
    if stamp.exists() and stamp.read_text() == LIST.read_text():
        return
    say("installing Mitsuba, Embree, pyrender and Blender's Cycles into .venv-peers (700 MB, once)")
    if not PYTHON.exists():
        # The version that there are wheels of Blender for.
        python = shutil.which("python3.11") or sys.executable
        subprocess.run([python, "-m", "venv", ENVIRONMENT], check=True)
    complete = True
    for line in LIST.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        requirement, *options = line.split(" --")
        done = subprocess.run([PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--retries", "1",
                               "--only-binary", ":all:", *(f"--{option}" for option in options), requirement],
                              capture_output=True, text=True)
        if done.returncode:
            complete = False
            say(f"{line.split('=')[0]} cannot be installed: {last_line(done.stderr)}")
    if complete:
        stamp.write_text(LIST.read_text())


def last_line(text):
    lines = [line for line in text.splitlines() if line.strip()]
    return lines[-1].strip() if lines else "it says nothing"


def command(name, *arguments):
    """Command that runs a peer once."""
    program, *options = PEERS[name][1]
    return [PYTHON, HERE / "workers" / program, *options, *map(str, arguments)]


class Peer:
    """A peer's process, which keeps what it has loaded and compiled."""

    def __init__(self, name):
        CACHE.mkdir(parents=True, exist_ok=True)
        self.name, self.log = name, CACHE / f"{name.replace(' ', '-')}.log"
        if not PYTHON.exists():
            raise Failed("it is not installed")
        with self.log.open("w") as log:
            self.process = subprocess.Popen(command(name), stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, text=True)
        self.about = self.ask("version")

    def ask(self, what, **arguments):
        try:
            self.process.stdin.write(json.dumps([what, arguments], default=str) + "\n")
            self.process.stdin.flush()
        except BrokenPipeError:
            pass
        answer = self.process.stdout.readline()
        if not answer:
            self.process.wait()
            raise Failed(last_line(self.log.read_text(errors="replace")))
        return json.loads(answer)

    def load(self, scene, size, **more):
        if self.name.startswith("mitsuba"):
            more = {"roulette": ROULETTE} | more
        return self.ask("load", path=scene, width=size[0], height=size[1], **more)

    def end(self):
        self.process.stdin.close()
        self.process.wait()


# Vertex from which Mitsuba's paths may end by roulette: its default, and raggio's paths have roulette too.
ROULETTE = 5


def available(names):
    """Peers of these names that run here, with what they say of themselves; of the others a line says why not."""
    found = {}
    for name in names:
        try:
            peer = Peer(name)
        except Failed as reason:
            say(f"{name} is left out: {reason}")
            continue
        found[name] = peer.about
        peer.end()
    return found
