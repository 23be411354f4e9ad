"""A run and its viewer, for the tests beside; and a WebSocket of plain sockets, which may say what no browser would."""
import base64
import json
import mmap
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = os.path.join(HERE, "..", "..", "..", "sim", "scenes")
sys.path.append(os.path.join(HERE, "..", "..", "support"))
from patience import PATIENCE_S, wait_for  # noqa: E402


def page_is_built(program):
    return os.path.exists(os.path.join(os.path.dirname(program), "..", "share", "tactus", "view", "index.html"))


class Run:
    """tactus run in real time, with a control socket."""

    def __init__(self, program, scene, *options):
        self.program, self.folder = program, tempfile.mkdtemp(prefix="tactus-view-")
        self.socket = os.path.join(self.folder, "c.sock")
        self.process = subprocess.Popen(
            [program, "run", os.path.join(SCENES, scene), "--control", self.socket, "--priority", "0", "--json", *options],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, cwd=self.folder, text=True)
        wait_for(lambda: os.path.exists(self.socket) and self.ask("state").get("ticks", 0) > 10, "run")

    def ask(self, what):
        out = subprocess.run([self.program, "control", what, "--socket", self.socket, "--json"], stdout=subprocess.PIPE, text=True).stdout
        return json.loads(out) if out else {"ticks": 0}

    def say(self, line):
        """One line of the control socket, as it is."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(self.socket)
            connection.sendall(line.encode() + b"\n")
            return json.loads(connection.makefile().readline())

    def end(self):
        if self.process.poll() is None:
            self.ask("stop")
        summary = json.loads(self.process.communicate(timeout=PATIENCE_S)[0])
        shutil.rmtree(self.folder)
        return summary


class Published:
    """What a controller publishes, read from its shared memory without a viewer: tools/publication/layout.h."""
    VERSION, HEADER, FRAME = 2, "<8s2IQd6Q2IQ", "<2Qd6I"

    def __init__(self, control):
        self.connection = socket.socket(socket.AF_UNIX)
        self.connection.settimeout(PATIENCE_S)
        self.connection.connect(control)
        self.connection.sendall(b"watch\n")
        answer, descriptors, _, _ = socket.recv_fds(self.connection, 4096, 1)
        assert len(descriptors) == 1, answer
        self.memory = mmap.mmap(descriptors[0], 0, prot=mmap.PROT_READ)
        os.close(descriptors[0])
        head = struct.unpack_from(self.HEADER, self.memory)
        assert head[:2] == (b"TACTPUB\0", self.VERSION), head
        self.frames_at, self.stride, self.bodies = head[7], head[8], head[12]

    def frame(self):
        """The newest: its time, x y z and w x y z of each moving body, and their roles; None where there is none yet or it was
        overtaken."""
        frames, = struct.unpack_from("<Q", self.memory, 128)
        if frames == 0:
            return None
        at = self.frames_at + (frames - 1) % 3 * self.stride
        slot = self.memory[at:at + self.stride]
        if {struct.unpack_from("<Q", slot)[0], struct.unpack_from("<Q", self.memory, at)[0]} != {2 * frames}:
            return None
        _, _, time_s, bodies, *_ = struct.unpack_from(self.FRAME, slot)
        positions = struct.iter_unpack("<3f", slot[48:48 + 12 * bodies])
        turns_at = 48 + (12 * bodies + 7) // 8 * 8
        rotations = struct.iter_unpack("<4h", slot[turns_at:turns_at + 8 * bodies])
        roles = list(slot[turns_at + 8 * bodies:turns_at + 9 * bodies])
        return time_s, [(place, [part / 32767 for part in turn]) for place, turn in zip(positions, rotations)], roles

    def standing(self):
        """The newest frame, once it is the newest twice."""
        return (one := self.frame()) and (two := self.frame()) and one == two and one

    def close(self):
        self.memory.close()
        self.connection.close()


class ViewedRun:
    """A run that starts its own viewer: the address is what it prints."""

    def __init__(self, program, *command):
        self.folder = tempfile.mkdtemp(prefix="tactus-steered-")
        self.process = subprocess.Popen([program, *command, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        cwd=self.folder, text=True)
        self.address = self.viewer_line()
        self.token, self.port = self.address.split("#")[1], int(self.address.split(":")[2].split("/")[0])

    def viewer_line(self):
        for line in self.process.stderr:
            if "http://" in line:
                self.line = line
                return line[line.index("http://"):].strip()
        raise AssertionError("no address")

    def kill(self):
        """Where a test has failed before its end()."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            self.process.communicate(timeout=3 * PATIENCE_S)

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        out, _ = self.process.communicate(timeout=3 * PATIENCE_S)
        shutil.rmtree(self.folder)
        return json.loads(out)


class AnyViewer:
    """tactus view with these options."""

    def __init__(self, program, *options):
        self.process = subprocess.Popen([program, "view", "--json", *options],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stderr.readline()
        assert "http://" in line, line
        self.address = line[line.index("http://"):].strip()
        self.token = self.address.split("#")[1].split("&")[0]
        self.port = int(self.address.split(":")[2].split("/")[0])

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGCONT)  # one that stands still would not see the next
            self.process.send_signal(signal.SIGTERM)
        out, _ = self.process.communicate(timeout=PATIENCE_S)
        return json.loads(out)


class Viewer(AnyViewer):
    """On a run."""

    def __init__(self, run, *options):
        super().__init__(run.program, "--socket", run.socket, *options)


class TapeViewer(AnyViewer):
    """On a tape, or two."""

    def end(self):
        return super().end() if self.process.stdout.closed is False else None


class Page:
    """A WebSocket. `status` is the answer's: 101 where the page is admitted."""

    def __init__(self, viewer, host=None, origin=None, token=None, path="/run"):
        host = f"127.0.0.1:{viewer.port}" if host is None else host
        origin = f"http://{host}" if origin is None else origin
        token = viewer.token if token is None else token
        self.socket = socket.create_connection(("127.0.0.1", viewer.port), timeout=PATIENCE_S)
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall((f"GET {path} HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nUpgrade: websocket\r\n"
                             f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
                             f"Sec-WebSocket-Protocol: tactus, {token}\r\n\r\n").encode())
        self.bytes = b""
        while b"\r\n\r\n" not in self.bytes and self.receive():
            pass
        head, _, self.bytes = self.bytes.partition(b"\r\n\r\n")
        self.status = int(head.split()[1])

    def receive(self):
        got = self.socket.recv(1 << 16)
        self.bytes += got
        return len(got)

    def message(self):
        """The next message: text as str, others as bytes; None where the server has closed."""
        while True:
            for head, size in ((2, 0), (4, 2), (10, 8)):
                if len(self.bytes) >= head and {126: 2, 127: 8}.get(self.bytes[1], 0) == size:
                    length = self.bytes[1] if size == 0 else int.from_bytes(self.bytes[2:head], "big")
                    if len(self.bytes) < head + length:
                        break
                    kind, payload = self.bytes[0] & 15, self.bytes[head:head + length]
                    self.bytes = self.bytes[head + length:]
                    return payload.decode() if kind == 1 else payload if kind == 2 else None
            try:
                if not self.receive():
                    return None
            except ConnectionResetError:
                return None

    def send(self, text):
        payload, mask = text.encode(), os.urandom(4)
        size = len(payload)
        head = bytes([0x81, 0x80 | size]) if size < 126 else bytes([0x81, 0xfe]) + struct.pack(">H", size)
        self.socket.sendall(head + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload)))

    def said(self, kind, **has):
        """The next text of this kind that has these values; binary messages before it are acknowledged."""
        while (message := self.message()) is not None:
            if isinstance(message, bytes):
                self.send(json.dumps({"ack": struct.unpack_from("<I", message, 8)[0]}))
                continue
            text = json.loads(message)
            if text["kind"] == kind and all(text.get(name) == value for name, value in has.items()):
                return text
        raise AssertionError(f"closed without '{kind}'")

    def asks(self, ask, **more):
        self.send(json.dumps({"ask": ask, **more}))
        return self.said("answer", ask=ask)

    def close(self):
        self.socket.close()


MEMBER = 2  # a bit of a role


def first_frame(viewer):
    """Of the viewer's present moment, by another page's first frame: the scene, each moving body's role by id, and the pairs of
    moving bodies in contact."""
    page = Page(viewer)
    scene = json.loads(page.message())
    while not isinstance(message := page.message(), bytes) or not struct.unpack_from("<I", message, 60)[0] & 1:
        if isinstance(message, bytes):
            page.send(json.dumps({"ack": struct.unpack_from("<I", message, 8)[0]}))
    page.close()
    count, roles, ticks, contacts = struct.unpack_from("<4I", message, 24)
    moving = [i for i, body in enumerate(scene["bodies"]) if not body["fixed"]]
    assert (count, roles) == (len(moving), len(moving)), (count, roles, len(moving))
    at = 64 + 20 * count
    role = {moving[word & 0xffffff]: word >> 24 for (word,) in struct.iter_unpack("<I", message[at:at + 4 * roles])}
    at += 4 * roles + 96 * ticks
    known = set(moving)
    pairs = {pair for *_, a, b in struct.iter_unpack("<6f2I", message[at:at + 32 * contacts]) if {a, b} <= known for pair in [(a, b)]}
    return scene, role, pairs


def graph_of(viewer):
    """What the graph is to show of the viewer's present moment, as the page names them: contacts of bodies that contacts connect
    to the proxy, of which one is a member or both touch one; those bodies; and the number of members that are not among them."""
    scene, role, pairs = first_frame(viewer)
    linked, found = {scene["proxy"]}, True
    while found:
        found = {body for pair in pairs if linked & set(pair) for body in pair} - linked
        linked |= found
    near = {scene["proxy"]} | {body for pair in pairs if any(role[one] & MEMBER for one in pair) for body in pair}
    shown = near & linked
    unlinked = sum(1 for body, bits in role.items() if bits & MEMBER and body not in shown)
    return {f"{a},{b}" for a, b in pairs if {a, b} <= shown}, {str(body) for body in shown}, unlinked


def note_of(viewer):
    """What the page of a tape says of its world, once it is rebuilt or cannot be."""
    page = Page(viewer)
    while (message := page.message()) is not None:
        if isinstance(message, bytes):
            page.send(json.dumps({"ack": struct.unpack_from("<I", message, 8)[0]}))
        elif json.loads(message)["kind"] == "tape" and "being rebuilt" not in message:
            page.close()
            return json.loads(message)["tapes"][0]["note"]
    raise AssertionError("closed")


def fetch(viewer, path, host=None, method="GET"):
    with socket.create_connection(("127.0.0.1", viewer.port), timeout=PATIENCE_S) as connection:
        connection.sendall(f"{method} {path} HTTP/1.1\r\nHost: {host or f'127.0.0.1:{viewer.port}'}\r\n\r\n".encode())
        answer = b""
        while part := connection.recv(1 << 16):
            answer += part
    head, _, body = answer.partition(b"\r\n\r\n")
    return int(head.split()[1]), head.decode(), body


def skip(why):
    print(f"tactus-skipped: {why}")
    sys.exit(77)
