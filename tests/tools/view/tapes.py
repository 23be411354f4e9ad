#!/usr/bin/python3
"""tests/tools/view/tapes.py PROGRAM: tapes in the page: played, scrubbed, stepped, two in step, brought back by a link; and what is
no tape is refused. Exit 77 where there is no browser or no page."""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import in_browser  # noqa: E402
from watched_run import SCENES, Page, TapeViewer, skip, wait_for  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else ""


MEMBER = 2  # a bit of a role
CARDS = os.path.join(SCENES, "card_house.toml")
FAULT = ["--inject", "lost@1500+500"]  # the device is silent for half a second


def record(program, path, *options):
    run = subprocess.run([program, "run", os.path.join(SCENES, "card_house.toml"), "--virtual-time", "--duration", "3", "--record", path, *options],
                         check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if run.returncode not in (0, 1):  # 1: the verdict of a run with a fault
        raise RuntimeError(f"tactus run ended with {run.returncode}")


class Tapes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="tactus-tapes-")
        cls.a, cls.b, cls.faulty = (os.path.join(cls.folder, name) for name in ("a.tape", "b.tape", "fault.tape"))
        record(PROGRAM, cls.faulty, *FAULT)
        record(PROGRAM, cls.a)
        record(PROGRAM, cls.b, "--coupling", "direct")
        cls.browser = in_browser.open_browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        shutil.rmtree(cls.folder)

    def open(self, *options):
        self.viewer = TapeViewer(PROGRAM, *options)
        self.addCleanup(self.viewer.end)
        self.browser.get("about:blank")  # else a new fragment alone loads nothing
        self.browser.get(self.viewer.address)
        wait_for(lambda: self.text("state").startswith("tape: "), "tape")

    def text(self, name):
        return self.browser.execute_script("return document.getElementById(arguments[0]).textContent", name)

    def canvas(self, name="canvas"):
        return self.browser.execute_script("return {...document.getElementById(arguments[0]).dataset}", name)

    def click(self, what):
        self.browser.execute_script("document.querySelector(`[data-time=${arguments[0]}]`).click()", what)

    def scrub(self, time_s):
        self.browser.execute_script(
            "const e = document.getElementById('scrub'); e.value = arguments[0]; e.dispatchEvent(new Event('input'))", time_s)
        wait_for(lambda: self.text("time") == f"{time_s:.3f}", f"{time_s} s, which is {self.text('time')}")

    def picture(self):
        """The canvas, as text, once it has drawn the figures' moment."""
        return self.browser.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() =>"
            " done(document.getElementById('canvas').toDataURL())))")

    def bodies(self, name="canvas"):
        data = self.canvas(name)
        return int(data.get("solid", 0)) + int(data.get("outside", 0))

    def test_1_a_tape_is_played_stepped_and_scrubbed_with_its_world(self):
        self.open(self.a)
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        wait_for(lambda: self.bodies() == 27, "bodies")
        self.assertEqual(self.text("time"), "0.001")
        self.assertTrue(self.browser.find_element("id", "scrub").is_displayed())
        self.click("tick")
        wait_for(lambda: self.text("time") == "0.002", "second tick")
        self.click("back")
        wait_for(lambda: self.text("time") == "0.001", "tick before")
        self.click("cycle")
        wait_for(lambda: float(self.text("time")) >= 0.009, "next cycle")
        self.scrub(2.0)
        force, members, picture = self.text("force"), self.text("members"), self.picture()
        self.scrub(0.5)
        self.scrub(2.0)
        self.assertEqual((self.text("force"), self.text("members"), self.picture()), (force, members, picture))
        self.click("play")
        wait_for(lambda: self.text("time") == "3.000", "end")
        wait_for(lambda: self.browser.find_element("css selector", "[data-time=play]").text == "play", "pause at the end")

    def test_1b_the_graph_is_that_of_the_contacts_that_were_sent(self):
        self.open(self.a)
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        self.scrub(2.0)
        self.picture()
        edges, bodies = self.contacts_near_members()
        self.assertGreater(len(edges), 10)
        graph = lambda name: set(self.browser.execute_script(  # noqa: E731
            "return [...document.querySelectorAll(`#graph [${arguments[0]}]`)].map((e) => e.getAttribute(arguments[0]))", name))
        wait_for(lambda: graph("data-edge") == edges, f"edges {edges}")
        self.assertEqual(graph("data-body"), bodies)

    def contacts_near_members(self):
        """Of the viewer's present moment, by another page's first frame: contacts of moving bodies of which one is a member, or
        both touch one; and their bodies."""
        page = Page(self.viewer)
        scene = json.loads(page.message())
        while not isinstance(message := page.message(), bytes) or not struct.unpack_from("<I", message, 60)[0] & 1:
            pass
        page.close()
        count, roles, ticks, contacts = struct.unpack_from("<4I", message, 24)
        moving = [i for i, body in enumerate(scene["bodies"]) if not body["fixed"]]
        self.assertEqual((count, roles), (len(moving), len(moving)))
        at = 64 + 20 * count
        role = {moving[word & 0xffffff]: word >> 24 for (word,) in struct.iter_unpack("<I", message[at:at + 4 * roles])}
        at += 4 * roles + 96 * ticks
        pairs = {pair for *_, a, b in struct.iter_unpack("<6f2I", message[at:at + 32 * contacts])
                 if {a, b} <= set(moving) for pair in [(a, b)]}
        near = {scene["proxy"]} | {body for pair in pairs if any(role[one] & MEMBER for one in pair) for body in pair}
        return {f"{a},{b}" for a, b in pairs if {a, b} <= near}, {str(body) for body in near}

    def test_2_a_link_brings_the_view_back(self):
        self.open(self.a)
        self.scrub(1.25)
        self.browser.execute_script(
            "const s = document.getElementById('signal'); s.value = '2'; s.dispatchEvent(new Event('change'));"
            " const f = document.querySelector('[name=forces]'); f.checked = false; f.dispatchEvent(new Event('input', {bubbles: true}))")
        address = wait_for(lambda: "signal=2" in self.browser.current_url and "at=1.25&" in self.browser.current_url
                           and "hide=forces" in self.browser.current_url and self.browser.current_url, "link")
        link = re.sub(r"^.*#[0-9a-f]{32}&", "", address)
        self.viewer.end()
        self.open(self.a, "--link", link)
        wait_for(lambda: self.text("time") == "1.250", "moment of the link")
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        self.assertEqual(self.browser.execute_script("return document.getElementById('signal').value"), "2")
        self.assertEqual(self.canvas()["arrows"], "0")
        wait_for(lambda: self.browser.current_url.endswith("&" + link), "the same view: camera, moment, signal, layers")

    def test_3_two_tapes_keep_step(self):
        self.open(self.a, "--beside", self.b)
        wait_for(lambda: self.bodies("canvas_beside") == 27 and self.bodies() == 27, "bodies of both")
        self.assertIn("the direct coupling has no world outside", self.text("note"))
        self.scrub(1.0)
        wait_for(lambda: self.browser.execute_script(
            "return document.querySelectorAll('.u-legend .u-series').length") == 6, "line of the second tape")
        self.assertEqual(self.canvas("canvas_beside")["solid"], "27")  # of the direct coupling all are members
        self.assertEqual([line["message"] for line in self.browser.get_log("browser")], [])

    def test_3b_numbered_frames_are_one_a_frame_and_of_different_moments(self):
        self.open(self.a)
        self.browser.execute_script(
            "window.frames_ = []; HTMLAnchorElement.prototype.click = function () { window.frames_.push(this.download) };"
            " URL.createObjectURL = (blob) => `#${blob.type} ${blob.size}`")
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        self.scrub(0.5)
        saved = lambda: self.browser.execute_script("return window.frames_")  # noqa: E731
        self.assertEqual(saved(), [])
        self.browser.execute_script("document.getElementById('numbered').checked = true")
        for _ in range(3):
            drawn = self.browser.execute_script("return document.body.dataset.pictures")
            self.click("tick")
            wait_for(lambda: self.browser.execute_script("return document.body.dataset.pictures") != drawn, "picture")
        wait_for(lambda: len(saved()) >= 3, "three files")
        self.assertEqual(saved(), [f"card_house_{i:06}.png" for i in range(len(saved()))])
        self.browser.execute_script("document.getElementById('numbered').checked = false")
        count = len(saved())
        self.scrub(1.0)
        self.assertEqual(len(saved()), count)

    def test_3c_the_verdict_is_the_run_s(self):
        for path, options in ((self.a, []), (self.b, ["--coupling", "direct"]), (self.faulty, FAULT)):
            said = json.loads(subprocess.run([PROGRAM, "run", CARDS, "--virtual-time", "--duration", "3", "--json", *options],
                                             capture_output=True, text=True, check=False).stdout)
            self.open(path)
            verdict = wait_for(lambda: "(of the whole tape" in self.text("verdict") and self.text("verdict"), "verdict")
            self.assertEqual(verdict, f"{said['verdict']} (of the whole tape)")
            self.viewer.end()
        self.assertTrue(verdict.startswith("BAD: a fault is latched"), verdict)
        self.assertIn("bad      fault", self.text("why"))

    def test_3d_what_is_not_measured_has_no_unit(self):
        self.open(self.a)
        self.scrub(1.0)
        self.assertEqual(self.text("age"), "not measured")
        self.assertEqual(self.text("overruns"), "not measured")
        header = self.browser.execute_script("return document.querySelector('header').textContent")
        self.assertNotRegex(header, "not measured *.s")

    def test_4_what_is_no_tape_is_refused_as_replay_does(self):
        foreign = os.path.join(self.folder, "foreign.tape")
        with open(foreign, "w", encoding="ascii") as file:
            file.write("this is no tape")
        for options in ([foreign], ["/nowhere.tape"], [self.a, "--beside", foreign]):
            done = subprocess.run([PROGRAM, "view", *options], capture_output=True, text=True, timeout=60)
            replayed = subprocess.run([PROGRAM, "replay", options[-1]], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertEqual(done.stderr.split(": ", 1)[1].split("tape '")[1], replayed.stderr.split("tape '")[1])
        both = subprocess.run([PROGRAM, "view", self.a, "--socket", "c.sock"], capture_output=True, text=True, timeout=60)
        self.assertEqual(both.returncode, 2)

    def test_5_a_tape_that_is_cut_off_is_shown_up_to_there(self):
        cut = os.path.join(self.folder, "cut.tape")
        with open(self.a, "rb") as file:
            whole = file.read()
        with open(cut, "wb") as file:
            file.write(whole[:2 * len(whole) // 3])
        self.open(cut)
        wait_for(lambda: "cut off at byte" in self.text("note"), "reason")
        self.click("play")
        wait_for(lambda: self.browser.find_element("css selector", "[data-time=play]").text == "play", "pause at the end")
        self.assertGreater(float(self.text("time")), 1)
        self.assertLess(float(self.text("time")), 3)


if __name__ == "__main__":
    in_browser.PROGRAM = PROGRAM
    if (why := in_browser.missing()) is not None:
        skip(why)
    sys.exit(0 if unittest.main(exit=False).result.wasSuccessful() else 1)
