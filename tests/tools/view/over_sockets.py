#!/usr/bin/python3
"""tests/tools/view/over_sockets.py PROGRAM: who may not see a run is refused; a page gets what the wire says, and what goes
wrong with a viewer is nothing to the run. Exit 77 where the page is not built."""
import json
import os
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from types import SimpleNamespace  # noqa: E402

from watched_run import PATIENCE_S, SCENES, Page, Run, Viewer, fetch, page_is_built, skip, wait_for  # noqa: E402
from long import long  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1))


def header_of(message):
    names = ("magic", "version", "number", "tick_age_us", "time_s", "bodies", "roles", "ticks", "contacts", "dropped", "lost_ticks",
             "component", "left_out", "resets", "flags")
    head = dict(zip(names, struct.unpack_from("<IIIfdIIIIIIIIII", message)))
    return {**head, "has_frame": head["flags"] & 1, "full": head["flags"] & 4}


class OverSockets(unittest.TestCase):
    def setUp(self):
        self.run_, self.viewer = Run(PROGRAM, "card_house.toml"), None
        self.viewer = Viewer(self.run_)
        self.pages = []

    def tearDown(self):
        for page in self.pages:
            page.close()
        if self.viewer.process.poll() is None:
            self.viewer.end()
        if self.run_.process.poll() is None:
            self.run_.end()

    def page(self, **given):
        self.pages.append(Page(self.viewer, **given))
        return self.pages[-1]

    def test_who_is_not_admitted(self):
        for status, given in ((421, {"host": "example.org"}), (421, {"host": "127.0.0.1.example.org:80"}),
                              (403, {"origin": "http://example.org"}), (403, {"origin": "http://127.0.0.1:1"}),
                              (403, {"token": ""}), (403, {"token": "0" * 32}), (404, {"path": "/other"})):
            with self.subTest(given=given):
                self.assertEqual(self.page(**given).status, status)
        admitted = [self.page() for _ in range(4)]
        for page in admitted:
            self.assertEqual(page.status, 101)
            self.assertEqual(json.loads(page.message())["kind"], "scene")
        self.assertEqual(self.page().status, 503)
        refused = self.viewer.end()["refused"]
        self.assertEqual(refused, {"host": 2, "origin": 2, "path": 1, "pages": 1, "token": 2})

    def test_files_are_the_page_s_alone(self):
        status, head, body = fetch(self.viewer, "/")
        self.assertEqual(status, 200)
        self.assertIn("Content-Security-Policy: default-src 'self'", head)
        self.assertIn(b"<canvas", body)
        self.assertNotIn(self.viewer.token.encode(), body)
        for path in ("/../../../etc/passwd", "/%2e%2e/secret", "/index.html/", "//etc/passwd", "/share", "/page.js.map"):
            self.assertEqual(fetch(self.viewer, path)[0], 404, path)
        self.assertEqual(fetch(self.viewer, "/", host="example.org")[0], 421)
        self.assertEqual(fetch(self.viewer, "/", method="POST")[0], 405)

    def test_a_page_gets_the_run_and_no_more_than_two_messages_ahead(self):
        page = self.page()
        scene = json.loads(page.message())
        moving = sum(not body["fixed"] for body in scene["bodies"])
        self.assertEqual((scene["name"], moving, len(scene["channels"])), ("card_house", 27, 24))
        ticks, bodies, number = [], 0, 0
        while len(ticks) < 1000:
            message = self.binary(page)
            head = header_of(message)
            self.assertEqual((head["magic"], head["version"], head["number"]), (0x46434154, 3, number + 1))
            number = head["number"]
            indices = 0 if head["full"] or not head["has_frame"] else 4 * head["bodies"]
            blocks = 64 + indices + 20 * head["bodies"] + 4 * head["roles"]
            self.assertEqual(len(message), blocks + 96 * head["ticks"] + 32 * head["contacts"])
            ticks += [int(struct.unpack_from("<f", message, blocks + 96 * i)[0]) for i in range(head["ticks"])]
            bodies = max(bodies, head["bodies"])
            page.send(json.dumps({"ack": number}))
        self.assertEqual(bodies, 27)
        if head["lost_ticks"] == 0:
            self.assertEqual(ticks, list(range(ticks[0], ticks[0] + len(ticks))))
        else:
            self.assertEqual(ticks, sorted(set(ticks)))
        # Without acknowledgement two more come, whatever the time.
        self.binary(page), self.binary(page)
        before = self.run_.ask("state")["ticks"]
        wait_for(lambda: self.run_.ask("state")["ticks"] > before + 1000, "ticks")
        page.send('{"ask": "disarm"}')
        while (text := json.loads(page.message()))["kind"] != "answer":  # what comes until then is text
            self.assertEqual(text["kind"], "state")

    def test_what_a_page_may_not_say(self):
        page = self.page()
        page.message()
        page.send('{"fly": 1}')
        answer = self.answer(page, "refused")
        self.assertIn("; accepted: ", answer["said"])
        page.send("x" * 300)
        self.assertIsNone(self.drained(page))
        page.close()  # only then has the server seen the end of it
        hasty = self.page()
        hasty.message()
        try:
            for _ in range(600):
                hasty.send('{"ack": 1}')
        except (BrokenPipeError, ConnectionResetError):
            pass
        self.assertIsNone(self.drained(hasty))
        refused = self.viewer.end()["refused"]
        self.assertEqual(refused["message"], 2)
        self.assertEqual(refused["rate"], 1)

    def answer(self, page, kind):
        while (message := page.message()) is not None:
            if isinstance(message, str) and json.loads(message)["kind"] == kind:
                return json.loads(message)
        self.fail(f"closed without '{kind}'")

    @staticmethod
    def drained(page):
        while (message := page.message()) is not None:
            pass
        return message

    def test_a_page_disarms_and_stops_the_run(self):
        page = self.page()
        page.message()
        page.send('{"ask": "disarm"}')
        self.assertTrue(self.answer(page, "answer")["ok"])
        wait_for(lambda: not self.run_.ask("state")["armed"], "disarmed run")
        page.send('{"ask": "stop"}')
        self.assertTrue(self.answer(page, "answer")["ok"])
        self.answer(page, "ended")
        page.close()
        report = json.loads(self.viewer.process.communicate(timeout=PATIENCE_S)[0])
        self.assertTrue(report["run_ended"])
        self.assertEqual(report["clients_most"], 1)

    def test_force_on_a_real_device_is_not_given_from_a_page(self):
        self.viewer.end()
        self.run_.end()
        with open(os.path.join(SCENES, "card_house.toml"), encoding="utf-8") as file:
            scene = re.sub(r"(?m)^stiffness_N_per_m = .*", "stiffness_N_per_m = 250", file.read(), count=1)
        scene = re.sub(r"(?m)^damping_Ns_per_m = .*", "damping_Ns_per_m = 0.5", scene, count=1)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "soft.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(scene)
        self.run_ = Run(PROGRAM, path, "--device", "falcon-sim")  # to the viewer it is a device with a person's hand on it
        self.viewer = Viewer(self.run_)
        page = self.page()
        for ask in ("arm", "rearm", "reset"):
            answer = page.asks(ask)
            self.assertEqual((answer["ok"], answer["said"]), (
                False, "force on a real device is not given from a page; accepted: tactus view --allow-force"))
        self.assertFalse(page.asks("take")["ok"])
        self.assertTrue(page.asks("disarm")["ok"])
        page.close()
        self.assertEqual(self.viewer.end()["refused"], {"force": 3, "hand": 1})
        self.viewer = Viewer(self.run_, "--allow-force")
        for ask in ("arm", "rearm", "reset"):
            self.assertTrue(self.page().asks(ask)["ok"], ask)

    def test_a_viewer_that_is_killed_or_hangs_is_nothing_to_the_run(self):
        other = Viewer(self.run_)
        watched = Page(other)
        self.pages.append(watched)
        while not isinstance(watched.message(), bytes):
            pass
        os.kill(other.process.pid, signal.SIGSTOP)
        page = self.page()
        self.assertEqual(page.status, 101)
        self.viewer.process.kill()
        self.viewer.process.communicate()
        before = self.run_.ask("state")["ticks"]
        wait_for(lambda: self.run_.ask("state")["ticks"] > before + 5000, "ticks")
        os.kill(other.process.pid, signal.SIGCONT)
        other.process.kill()
        other.process.communicate()
        summary = self.run_.end()
        self.assertEqual(summary["timing"]["overruns_own_work"], 0)

    def test_the_verdict_is_told_while_it_runs_and_at_the_end_as_the_summary_has_it(self):
        page = self.page()
        so_far = page.said("state", ended=False)
        self.assertIn(so_far["level"], ("good", "degraded", "bad"))
        self.assertEqual(so_far["fault_tape"], "")
        page.asks("stop")
        last = page.said("state", ended=True)
        summary = self.run_.end()
        self.assertEqual(last["verdict"], summary["verdict"])

    def test_a_fault_opens_its_last_seconds(self):
        self.run_.end()
        self.viewer.end()
        self.run_ = Run(PROGRAM, "card_house.toml", "--inject", "lost@3000+1000000")
        self.viewer = Viewer(self.run_)
        page = self.page()
        while not (state := page.said("state")).get("fault_page"):
            pass
        self.assertEqual((state["level"], state["verdict"][:25]), ("bad", "BAD: a fault is latched: "))
        self.assertEqual(state["fault_tape"], os.path.join(os.path.realpath(self.run_.folder), "tactus-fault.tape"))
        fault = SimpleNamespace(port=int(state["fault_page"].split(":")[2].split("/")[0]), token=state["fault_page"].split("#")[1])
        self.assertNotEqual(fault.token, self.viewer.token)
        self.pages.append(Page(fault))
        tape = self.pages[-1].said("tape")["tapes"][0]
        self.assertEqual(len(tape["faults_s"]), 1)
        self.assertGreater(tape["faults_s"][0], 3)
        stranger = Page(SimpleNamespace(port=fault.port, token=self.viewer.token))
        self.assertEqual(stranger.status, 403)
        stranger.close()

    def test_four_pages_get_the_same_ticks_and_one_that_takes_nothing_delays_none(self):
        pages = [self.page() for _ in range(4)]
        for page in pages:
            self.assertEqual(json.loads(page.message())["kind"], "scene")
        frozen, others = pages[0], pages[1:]
        seen = [dict() for _ in others]
        before = self.run_.ask("state")["ticks"]
        for page, ticks in zip(others, seen):
            while len(ticks) < 2000:
                self.take_ticks(page, ticks)
        for page, ticks in zip(others, seen):  # up to the same tick
            while max(ticks) < max(max(one) for one in seen):
                self.take_ticks(page, ticks)
        common = set.intersection(*(set(one) for one in seen))
        self.assertGreater(len(common), 1000)
        for tick in common:
            self.assertEqual(len({one[tick] for one in seen}), 1)
        self.assertGreater(self.run_.ask("state")["ticks"], before)
        # Two messages wait in the frozen one, and no more; the next one says how many frames it did not get.
        first, second = (self.binary(frozen) for _ in range(2))
        frozen.send(json.dumps({"ack": header_of(second)["number"]}))
        third = header_of(self.binary(frozen))
        self.assertEqual([header_of(first)["number"], header_of(second)["number"], third["number"]], [1, 2, 3])
        self.assertGreater(third["dropped"], 10)
        for page in pages:
            page.close()
        self.assertGreaterEqual(self.viewer.end()["frames_dropped"], third["dropped"])
        self.assertEqual(self.run_.end()["timing"]["overruns_own_work"], 0)

    @staticmethod
    def binary(page):
        while not isinstance(message := page.message(), bytes):
            pass
        return message

    def take_ticks(self, page, ticks):
        """Of the next message, by number: the row's bytes. It is acknowledged."""
        message = self.binary(page)
        head = header_of(message)
        at = 64 + (0 if head["full"] or not head["has_frame"] else 4 * head["bodies"]) + 20 * head["bodies"] + 4 * head["roles"]
        for row in (message[at + 96 * i:at + 96 * (i + 1)] for i in range(head["ticks"])):
            ticks[int(struct.unpack_from("<f", row)[0])] = row
        page.send(json.dumps({"ack": head["number"]}))

    @long
    def test_a_viewer_that_stands_still_for_30_s_of_the_run_changes_no_bit_and_goes_on(self):
        self.viewer.end()
        self.run_.end()
        options = ["--virtual-time", "--duration", "60"]
        plain = json.loads(subprocess.run([PROGRAM, "run", os.path.join(SCENES, "incline.toml"), *options, "--json"],
                                          capture_output=True, text=True, check=False).stdout)
        self.run_ = Run(PROGRAM, "incline.toml", *options, "--pace", "1")
        self.viewer = Viewer(self.run_)
        page = self.page()
        page.asks("pause")
        head = self.until_number(page, 2)
        os.kill(self.viewer.process.pid, signal.SIGSTOP)
        before = self.run_.ask("state")["ticks"]
        self.run_.say("pace 0")
        self.run_.say("play")
        wait_for(lambda: self.run_.ask("state")["ticks"] >= before + 30000, "30 s of virtual time")
        self.run_.say("pause")
        os.kill(self.viewer.process.pid, signal.SIGCONT)
        page.send(json.dumps({"ack": head["number"]}))
        while (late := header_of(self.binary(page)))["lost_ticks"] == 0:
            page.send(json.dumps({"ack": late["number"]}))
        self.assertGreater(late["lost_ticks"], 30000 - 16384 - 4096 - 1)  # the ring of the run, and what waits for a page
        page.send('{"ask": "play"}')
        summary = json.loads(self.run_.process.communicate(timeout=PATIENCE_S)[0])
        self.assertEqual(summary["state_hash"], plain["state_hash"])

    def until_number(self, page, number):
        while (head := header_of(self.binary(page)))["number"] < number:
            page.send(json.dumps({"ack": head["number"]}))
        return head

    def test_a_run_that_is_killed_is_over_for_its_pages(self):
        page = self.page()
        page.message()
        self.run_.process.kill()
        self.run_.process.communicate()
        self.answer(page, "ended")

    @long
    def test_timing_has_windows_with_a_viewer_and_without_in_turns(self):
        self.viewer.end()
        self.run_.end()
        done = subprocess.run([PROGRAM, "timing", "--with-viewer", "--window", "0.5", "--duration", "9", "--members", "8", "--priority", "0",
                               "--json"], capture_output=True, text=True, timeout=3 * PATIENCE_S, check=False)
        self.assertIn(done.returncode, (0, 1), done.stderr)  # 1: the verdict on this machine's times
        viewer = json.loads(done.stdout)["viewer"]
        for side in ("with", "without"):
            self.assertGreaterEqual(viewer[side]["windows"], 1, side)
            for times in ("wake", "execution"):
                self.assertEqual(viewer[side][times]["count"], viewer[side]["ticks"])
        self.assertGreater(viewer["with"]["frames"], 0)
        self.assertEqual(viewer["without"]["frames"], 0)
        for ratio in ("wake_ratio_p50", "wake_ratio_p99", "execution_ratio_p50", "execution_ratio_p99"):
            self.assertGreater(viewer[ratio], 0)

    def test_a_socket_that_one_may_not_write_to_is_one_line(self):
        os.chmod(self.run_.socket, 0)
        # Root may write to any: without that right it is a user as others are.
        without_right = ["setpriv", "--bounding-set=-dac_override", "--inh-caps=-dac_override"] if os.geteuid() == 0 else []
        done = subprocess.run([*without_right, PROGRAM, "view", "--socket", self.run_.socket], capture_output=True, text=True,
                              timeout=PATIENCE_S, check=False)
        os.chmod(self.run_.socket, 0o660)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        self.assertIn("this user may not ask there", done.stderr)
        self.assertIn(self.run_.socket, done.stderr)

    def test_what_is_missing_is_one_line(self):
        for options, says in ((["--socket", "/nowhere.sock"], "no run answers there"),
                              (["--socket", self.run_.socket, "--port", str(self.viewer.port)], "accepted: --port with a free one")):
            done = subprocess.run([PROGRAM, "view", *options], capture_output=True, text=True, timeout=PATIENCE_S)
            self.assertEqual(done.returncode, 3)
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn(says, done.stderr)


if __name__ == "__main__":
    if not page_is_built(PROGRAM):
        skip("the page is not built: no node or npm")
    sys.exit(0 if unittest.main(exit=False).result.wasSuccessful() else 1)
