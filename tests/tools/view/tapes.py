#!/usr/bin/python3
"""tests/tools/view/tapes.py PROGRAM: tapes in the page: played, scrubbed, stepped, two in step, brought back by a link; and what is
no tape is refused. Exit 77 where there is no browser or no page."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import in_browser  # noqa: E402
from watched_run import MEMBER, SCENES, TapeViewer, first_frame, graph_of, skip, wait_for  # noqa: E402
from long import long  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else ""

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
        edges, bodies, _ = graph_of(self.viewer)
        self.assertGreater(len(edges), 10)
        graph = lambda name: set(self.browser.execute_script(  # noqa: E731
            "return [...document.querySelectorAll(`#graph [${arguments[0]}]`)].map((e) => e.getAttribute(arguments[0]))", name))
        wait_for(lambda: graph("data-edge") == edges, f"edges {edges}")
        self.assertEqual(graph("data-body"), bodies)

    @long
    def test_1c_what_is_scrubbed_to_is_what_playing_shows(self):
        """Played to a moment, then the same moment from before and from after it: figures and picture."""
        self.open(self.a, "--link", "at=1.6&pace=0.3")
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        wait_for(lambda: self.text("time") == "1.600", "beginning")
        self.click("play")
        wait_for(lambda: float(self.text("time")) > 1.75, "a moment of playing")
        self.click("play")
        wait_for(lambda: self.browser.find_element("css selector", "[data-time=play]").text == "play", "pause")
        played = self.stands()
        time_s = float(played[0])
        self.assertLess(time_s, 3)
        for elsewhere_s in (0.5, 2.9):
            self.scrub(elsewhere_s)
            self.scrub(time_s)
            self.assertEqual(self.stands(), played)

    def stands(self):
        """Figures, bodies' moment and picture, once they are the same twice."""
        look = lambda: (*(self.text(name) for name in ("time", "force", "members", "contacts")), self.canvas()["world_s"], self.picture())  # noqa: E731
        return wait_for(lambda: (one := look()) == look() and one, "still picture")

    @long
    def test_1d_after_scrubbing_back_time_does_not_run_backwards(self):
        self.open(self.a)
        self.scrub(2.0)
        wait_for(lambda: self.text("share") == "0.00", "share of a tape that stands still")
        self.browser.execute_script(
            "window.shares = []; const e = document.getElementById('share');"
            " new MutationObserver(() => window.shares.push(e.textContent)).observe(e, {childList: true, characterData: true, subtree: true})")
        self.scrub(0.5)
        shares = wait_for(lambda: (all_ := self.browser.execute_script("return window.shares")) and all_[-1] == "0.00" and all_, "share")
        self.assertEqual(shares, ["–", "0.00"])

    @long
    def test_1e_what_is_pointed_at_is_named_as_it_is_now(self):
        """A part of the workshop that the tool meets: a member then, and none before."""
        path = os.path.join(self.folder, "workshop.tape")
        subprocess.run([PROGRAM, "run", os.path.join(SCENES, "workshop.toml"), "--virtual-time", "--duration", "2", "--record", path],
                       check=True, capture_output=True)
        self.open(path)
        wait_for(lambda: "The world outside is rebuilt: " in self.text("note"), "rebuilt world")
        self.scrub(0.002)
        _, early, _ = first_frame(self.viewer)
        for time_s in (0.8, 1.1, 1.4, 1.7):
            self.scrub(time_s)
            self.picture()
            _, late, _ = first_frame(self.viewer)
            _, nodes, _ = graph_of(self.viewer)
            if met := [int(node) for node in nodes if late[int(node)] & MEMBER and not early[int(node)] & MEMBER]:
                break
        body, = met[:1]
        node = f'#graph [data-body="{body}"]'
        wait_for(lambda: self.browser.execute_script("return document.querySelector(arguments[0])", node), "body in the graph")
        self.browser.execute_script(
            "document.querySelector(arguments[0]).dispatchEvent(new PointerEvent('pointerover', {bubbles: true}))", node)
        wait_for(lambda: "member" in self.text("hover"), "name")
        # Its edges are no border's.
        look = lambda: self.browser.execute_script("return document.getElementById('canvas').look(arguments[0])", body)  # noqa: E731
        wait_for(lambda: look()["edge"] == "#0000ff", "edges of what is pointed at")
        self.assertIn("pointed at: blue edges", self.text("legend"))
        self.scrub(0.002)
        wait_for(lambda: "member" not in self.text("hover"), "role of this moment")

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

    @long
    def test_2b_what_a_link_may_not_say_is_left_out_and_said(self):
        self.open(self.a, "--link", "signal=99&window=7&pace=-1&eye=1,2&scale=1&hide=all&fly=1&at=1.5")
        wait_for(lambda: self.text("time") == "1.500", "what is right in it")
        chosen = self.browser.execute_script("return ['signal', 'window', 'pace'].map((name) => document.getElementById(name).value)")
        self.assertEqual(chosen, ["0", "10", "1"])
        lines = self.text("answer").split(" · ")
        self.assertEqual([line.split(" is left out; accepted: ")[0] for line in lines],
                         [f"link: {word}" for word in ("pace=-1", "signal=99", "window=7", "eye=1,2", "scale=1", "hide=all", "fly=1")])
        wait_for(lambda: "signal=0&window=10&" in self.browser.current_url and "fly" not in self.browser.current_url, "address")

    def test_3_two_tapes_keep_step(self):
        self.open(self.a, "--beside", self.b)
        wait_for(lambda: self.bodies("canvas_beside") == 27 and self.bodies() == 27, "bodies of both")
        self.assertIn("the direct coupling has no world outside", self.text("note"))
        self.scrub(1.0)
        wait_for(lambda: self.browser.execute_script(
            "return document.querySelectorAll('.u-legend .u-series').length") == 6, "line of the second tape")
        self.assertEqual(self.canvas("canvas_beside")["solid"], "27")  # of the direct coupling all are members
        self.assertEqual([line["message"] for line in self.browser.get_log("browser")], [])

    @long
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

    @long
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
