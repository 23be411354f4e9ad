#!/usr/bin/python3
"""tests/tools/view/steered.py PROGRAM: a run that a page steers: started with its viewer, stopped and stepped in virtual time, its
hand led by the mouse. Exit 77 where there is no browser or no page."""
import csv
import json
import math
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
from watched_run import PATIENCE_S, SCENES, Page, Run, TapeViewer, ViewedRun, Viewer, note_of, skip, wait_for  # noqa: E402
from long import long  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else ""
SHIFTED_RAD = 80 * 0.008  # what 80 pixels turn
CARDS = os.path.join(SCENES, "card_house.toml")


class Steered(in_browser.BrowserTest):
    def open(self, run):
        self.browser.get("about:blank")
        self.browser.get(run.address)
        wait_for(lambda: self.text("state").startswith("live: "), "page")

    def click(self, selector):
        self.browser.execute_script("document.querySelector(arguments[0]).click()", selector)

    def test_1_virtual_time_is_stopped_stepped_and_slowed_down_and_the_bits_stay(self):
        run = ViewedRun(PROGRAM, "view", CARDS, "--virtual-time", "--duration", "3", "--pace", "0.02")
        self.addCleanup(run.kill)
        self.open(run)
        self.assertEqual(self.text("state"), "live: virtual time")
        wait_for(lambda: self.text("time") != "–", "tick")
        self.click("[data-time=play]")
        wait_for(lambda: self.text("answer") == "paused", "answer")
        at = wait_for(lambda: self.stands(), "stop")
        self.click("[data-time=tick]")
        wait_for(lambda: self.text("time") == f"{at + 0.001:.3f}", "next tick")
        self.click("[data-time=cycle]")
        wait_for(lambda: at + 0.001 < float(self.text("time")) <= at + 0.03, "next cycle")
        self.browser.execute_script(
            "const e = document.getElementById('pace'); e.value = '0'; e.dispatchEvent(new Event('change'))")
        wait_for(lambda: self.text("answer") == "as fast as it goes", "answer")
        self.click("[data-time=play]")
        out, _ = run.process.communicate(timeout=PATIENCE_S)
        wait_for(lambda: self.text("state") == "the run is over", "end")
        plain = subprocess.run([PROGRAM, "run", CARDS, "--virtual-time", "--duration", "3", "--json"], capture_output=True, text=True, check=True)
        self.assertEqual(json.loads(out)["state_hash"], json.loads(plain.stdout)["state_hash"])
        shutil.rmtree(run.folder)

    def stands(self):
        """The time, once it stands still."""
        before = self.text("time")
        self.browser.execute_async_script("setTimeout(arguments[0], 400)")
        return float(before) if self.text("time") == before else None

    def test_2_the_mouse_pushes_a_card_and_the_run_replays(self):
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.keys import Keys
        tape = os.path.join(tempfile.mkdtemp(prefix="tactus-steered-"), "led.tape")
        run = ViewedRun(PROGRAM, "run", CARDS, "--view", "--hand", "pointer", "--priority", "0", "--record", tape)
        self.addCleanup(run.kill)
        self.open(run)
        wait_for(lambda: self.text("time") != "–", "tick")
        self.click("#take")
        wait_for(lambda: self.text("take") == "let the hand rest", "hand")
        self.assertEqual(self.text("answer"), "the hand is yours")
        second = Page(run)
        second.message()
        self.assertEqual(second.asks("take")["said"], "another page has the hand")
        second.close()
        canvas = self.browser.find_element("id", "canvas")
        self.browser.execute_script(
            "document.querySelector('input[name=mode][value=trigger]').checked = true;"
            " document.getElementById('trigger').dispatchEvent(new Event('change'))")  # above 1 N
        moves = ActionChains(self.browser, duration=100).move_to_element(canvas).click_and_hold()
        for _ in range(20):
            moves = moves.move_by_offset(0, 8)
        moves.release().key_down(Keys.SHIFT).click_and_hold()
        for _ in range(10):
            moves = moves.move_by_offset(8, 0)
        moves.release().key_up(Keys.SHIFT).perform()
        wait_for(lambda: self.text("caught").startswith("caught at"), "force of what the hand met")
        self.assertRegex(self.text("lag"), r"^pointer to tick \d+ ms, to this page \d+ ms$")
        self.assertGreater(self.farthest_moved(run), 0.05)
        plotted = self.saved("#csv")
        motion = wait_for(lambda: self.turned(self.saved("#save")), "hand that has turned")
        self.click("#take")
        wait_for(lambda: self.text("take") == "take the hand", "rest")
        summary = run.end()
        self.addCleanup(shutil.rmtree, os.path.dirname(tape))
        self.assertEqual(summary["timing"]["overruns_own_work"], 0)
        replayed = subprocess.run([PROGRAM, "replay", tape, "--json"], capture_output=True, text=True, check=False)
        self.assertTrue(json.loads(replayed.stdout)["good"], replayed.stdout)
        viewer = TapeViewer(PROGRAM, tape)
        self.assertRegex(note_of(viewer), "The world outside is rebuilt: [0-9]+ snapshots, as taped")  # of real time
        viewer.end()
        self.check_plot(plotted, tape)
        self.check_motion(motion, os.path.dirname(tape))
        self.check_turn(motion)

    @staticmethod
    def turn(q):
        """Of a rotation w x y z [rad]."""
        return 2 * math.atan2(math.hypot(*q[1:]), abs(q[0]))

    @staticmethod
    def rotations(motion):
        return [[float(row[f"rotation_{axis}"]) for axis in "wxyz"] for row in csv.DictReader(motion.splitlines())]

    def turned(self, motion):
        """The motion, once the hand is where shift and the mouse lead it."""
        return self.turn(self.rotations(motion)[-1]) > 0.99 * SHIFTED_RAD and motion

    def check_turn(self, motion):
        """About the picture's upward direction, and no further."""
        rows = self.rotations(motion)
        self.assertLess(self.turn(rows[0]), 0.02)  # the proxy's, to which the hand's is set
        self.assertAlmostEqual(self.turn(rows[-1]), SHIFTED_RAD, delta=0.03)
        for row in rows:
            self.assertAlmostEqual(math.hypot(*row), 1, delta=1e-6)

    def saved(self, button):
        """What the button would save as a file."""
        self.browser.execute_script("window.saved = null; URL.createObjectURL = (blob) => (blob.text().then((text) => (window.saved = text)), '#')")
        self.click(button)
        return wait_for(lambda: self.browser.execute_script("return window.saved"), f"what {button} saves")

    def check_plot(self, plotted, tape):
        """The plot's force is the tape's, bit by bit, as float32; a zero's sign is not in text."""
        single = lambda text: struct.unpack("<f", struct.pack("<f", float(text)))[0]  # noqa: E731
        table = tape + ".csv"
        subprocess.run([PROGRAM, "export", tape, "--csv", table, "--signals", "force"], capture_output=True, check=True)
        with open(table, encoding="ascii") as file:
            force = {row["tick"]: [row[f"force_{axis}_N"] for axis in "xyz"] for row in csv.DictReader(file)}
        rows = list(csv.DictReader(plotted.splitlines()))
        self.assertGreater(len(rows), 500)
        for row in rows:
            tick = str(round(float(row["time_s"]) * 1000) - 1)
            self.assertEqual([single(row[f"{axis}_N"]) for axis in "xyz"], [single(value) for value in force[tick]], tick)

    def check_motion(self, motion, folder):
        """The saved motion drives a scene's hand: the same fall twice."""
        with open(os.path.join(folder, "hand.csv"), "w", encoding="ascii") as file:
            file.write(motion)
        with open(CARDS, encoding="utf-8") as file:
            scene = re.sub(r"(?ms)^repeat = true\npath = \[.*?^\]", 'file = "hand.csv"', file.read())
        self.assertIn('file = "hand.csv"', scene)
        path = os.path.join(folder, "led.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene)
        runs = [json.loads(subprocess.run([PROGRAM, "run", path, "--virtual-time", "--duration", "5", "--json"], capture_output=True,
                                          text=True, check=False).stdout) for _ in range(2)]
        self.assertEqual(runs[0]["state_hash"], runs[1]["state_hash"])
        self.assertGreater(runs[0]["condition_ticks"]["proxy-contact"], 50)

    @staticmethod
    def farthest_moved(run):
        """Of all cards, by a page's first frame [m]."""
        page = Page(run)
        bodies = [body["position"] for body in json.loads(page.message())["bodies"] if not body["fixed"]]
        while not isinstance(message := page.message(), bytes) or not struct.unpack_from("<I", message, 60)[0] & 1:
            if isinstance(message, bytes):
                page.send(json.dumps({"ack": struct.unpack_from("<I", message, 8)[0]}))
        page.close()
        now = [struct.unpack_from("<3f", message, 64 + 12 * i) for i in range(len(bodies))]
        return max(max(abs(a - b) for a, b in zip(*both)) for both in zip(bodies[1:], now[1:]))

    @long
    def test_2b_a_gamepad_leads_the_hand_and_at_rest_it_does_not(self):
        run = ViewedRun(PROGRAM, "view", CARDS, "--virtual-time", "--hand", "pointer")
        self.addCleanup(run.kill)
        self.open(run)
        self.stub_gamepad(0, 0, 0, 0)
        self.note_wishes()
        self.click("#take")
        wait_for(lambda: self.text("take") == "let the hand rest", "hand")
        newest = lambda: self.browser.execute_script("return window.sent.slice(-1)[0]")  # noqa: E731
        wait_for(newest, "wish")
        self.stub_gamepad(0.1, -0.1, 0, 0.1)  # a stick never rests at nought
        count = self.browser.execute_script("return window.sent.length")
        wait_for(lambda: self.browser.execute_script("return window.sent.length") > count + 10, "wishes")
        self.assertEqual(newest(), [0] * 6)
        before = self.target()
        self.stub_gamepad(0, -1, 0, 0)  # up, in the picture's plane
        wait_for(lambda: math.hypot(*newest()[:3]) > 0.03, "way")
        self.stub_gamepad(0, 0, 0, 0)
        wish = newest()
        self.assertGreater(wish[2], 0.5 * math.hypot(*wish[:3]))  # the camera looks down at less than 60 degrees
        wait_for(lambda: self.target()[2] - before[2] > 0.5 * wish[2], "hand that follows")
        run.end()

    def note_wishes(self):
        """From now on window.sent has what the page wishes of the hand."""
        self.browser.execute_script(
            "window.sent = []; const send = WebSocket.prototype.send; WebSocket.prototype.send = function (text) {"
            " const hand = JSON.parse(text).hand; if (hand) window.sent.push(hand); return send.call(this, text) }")

    @long
    def test_2c_a_wish_goes_out_with_its_event_and_waits_for_no_picture(self):
        from selenium.webdriver.common.action_chains import ActionChains
        run = ViewedRun(PROGRAM, "view", CARDS, "--virtual-time", "--hand", "pointer")
        self.addCleanup(run.kill)
        self.open(run)
        self.note_wishes()
        self.click("#take")
        wait_for(lambda: self.text("take") == "let the hand rest", "hand")
        self.browser.execute_script("window.requestAnimationFrame = () => 0")  # after the one that waits, no picture more
        canvas = self.browser.find_element("id", "canvas")
        ActionChains(self.browser, duration=0).move_to_element(canvas).click_and_hold().perform()
        size = 0
        for _ in range(2):
            ActionChains(self.browser, duration=0).move_by_offset(30, 0).perform()
            wish = wait_for(lambda: self.browser.execute_script(
                "const at = window.sent.slice(-1)[0]; return at && Math.hypot(...at) > 1e-4 + 1.5 * arguments[0] && at", size),
                "wish of the move")
            size = math.hypot(*wish)
        self.assertEqual(wish[3:], [0, 0, 0])
        run.end()

    def choose(self, selector, value):
        self.browser.execute_script(
            "const e = document.querySelector(arguments[0]); if (e.type === 'radio') e.checked = true; else e.value = arguments[1];"
            " e.dispatchEvent(new Event('change'))", selector, value)

    def test_2d_a_fault_is_caught_with_the_ticks_before_it(self):
        run = ViewedRun(PROGRAM, "view", CARDS, "--virtual-time", "--inject", "lost@900+1000000", "--pace", "0.02")
        self.addCleanup(run.kill)
        self.open(run)
        self.choose("#window", "1")
        self.choose("#trigger", "fault")
        self.choose("input[name=mode][value=trigger]", "")
        self.choose("#pace", "1")
        wait_for(lambda: self.text("answer") == "1 times real time", "pace")
        caught = wait_for(lambda: "750 ticks since" in self.text("caught") and self.text("caught"), "fault")
        at_s = float(caught.split()[2])
        self.assertEqual(self.text("fault"), "number 1")  # the link was lost
        self.assertTrue(0.9 < at_s < 1.0, at_s)
        times_s = [float(row["time_s"]) for row in csv.DictReader(self.saved("#csv").splitlines())]
        self.assertAlmostEqual(times_s[0], at_s - 0.25, delta=0.005)  # a quarter of the window
        self.assertAlmostEqual(times_s[-1], at_s + 0.75, delta=0.005)
        run.end()

    def stub_gamepad(self, *axes):
        self.browser.execute_script(
            "const pad = { connected: true, axes: [...arguments] }; navigator.getGamepads = () => [null, pad]", *axes)

    def target(self):
        """Where the tool is, as the page has it [m]."""
        return [float(self.browser.execute_script(f"return document.body.dataset.target_{axis}")) for axis in "xyz"]

    def test_3_real_time_is_not_stopped(self):
        run = Run(PROGRAM, "card_house.toml")
        viewer = Viewer(run)
        page = Page(viewer)
        page.message()
        for ask in ("pause", "tick", "cycle", "play"):
            self.assertIn("real time cannot be paused", page.asks(ask)["said"])
        page.send('{"hand": [0, 0, 0, 0, 0, 0]}')  # not taken: refused and counted
        self.assertIn("a run cannot go back", page.asks("seek", value=1)["said"])
        page.close()
        self.assertEqual(viewer.end()["refused"].get("hand"), 1)
        run.end()

    def test_4_what_does_not_fit_is_refused(self):
        for options, says in ((["run", CARDS, "--pace", "1"], "--pace: real time has its own"),
                              (["run", CARDS, "--view", "--virtual-time", "--pace", "0.001"], "--pace: accepted: 0.01 to 100"),
                              (["run", CARDS, "--hand", "pointer", "--device", "usb"], "a real device's hand is a person's"),
                              (["view", "my.tape", "--besides", "b.tape"], "--besides")):
            done = subprocess.run([PROGRAM, *options], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(says, done.stderr)


if __name__ == "__main__":
    in_browser.PROGRAM = PROGRAM
    if (why := in_browser.missing()) is not None:
        skip(why)
    sys.exit(0 if unittest.main(exit=False).result.wasSuccessful() else 1)
