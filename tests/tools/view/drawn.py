#!/usr/bin/python3
"""tests/tools/view/drawn.py PROGRAM: what the page of tactus view draws and writes: bodies where the controller has them, every
scene of sim/scenes, a stall caught by the trigger, a unit for every figure. Exit 77 where there is no browser or no page."""
import csv
import json
import os
import re
import signal
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
from types import SimpleNamespace

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import in_browser  # noqa: E402
from watched_run import (  # noqa: E402
    MEMBER, SCENES, Page, Published, Run, TapeViewer, ViewedRun, Viewer, graph_of, skip, wait_for)
from long import LONG, long  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else ""
CARDS = os.path.join(SCENES, "card_house.toml")
TWO_HANDS = os.path.join(SCENES, "..", "..", "tools", "examples", "two_hands.toml")
# Of a body that is not sent again before it has moved by more (tools/view/wire.h), and of float32 at 1 m.
PLACE_M, TURN = 1e-5 + 1e-7, 1e-4 + 4 * 0.51 / 32767
COUNT, REAL = r"(–|\d+)", r"(–|-?\d+(\.\d+)?)"
# Of each <output>: what stands around it, as it is read.
FIGURES = {
    "unlinked": r"( members that contacts do not connect to it, not drawn here: \d+)?$",
    "time": rf"^{REAL} s$",
    "share": rf"^{REAL} × real time$",
    "members": r"^members (–|\d+/\d+)$",
    "contacts": rf"^contacts {COUNT}$",
    "force": rf"^force {REAL} N$",
    "age": r"^force age (–|\d+ µs|not measured)$",
    "overruns": rf"^overruns ({COUNT}|not measured)$",
    "fault": r"^fault (none|number \d+)( its last seconds)?$",
    "verdict": r"^verdict .+$",
    "dropped": r"^dropped \d+ frames, \d+ ticks$",
    "lost": r"^dropped \d+ frames, \d+ ticks$",
    "lag": r"^take the hand save its motion ?(pointer to tick -?\d+ ms, to this page -?\d+ ms)?$",
    "scale_mm": rf"^1 N = {REAL} mm$",
    "caught": r"(waiting|caught at \d+\.\d+ s, \d+ ticks since|CSV$)",
}
# As the page's legend has them, by the bits of a role: colour, colour of the edges, seen through.
PROXY, BORDER, ASLEEP = 1, 4, 8
LOOKS = {"proxy": ("#d55e00", "", False), "other": ("#f0e442", "#d55e00", False), "border": ("#e69f00", "#000000", False),
         "member": ("#56b4e9", "", False), "awake": ("#009e73", "", True), "asleep": ("#999999", "", True)}
MOST_BODIES = 300  # that are compared: of more, members and some of the others
UNITS = {"force": "N", "energy at the ports": "J", "counts": None, "deepest overlap": "mm", "times of a tick": "µs",
         "whole tick": "µs", "force age": "µs"}


def kind_of(bits):
    """Of LOOKS. The proxy is a member too, and so is a body at the border: each is drawn as what comes first here."""
    return ("proxy" if bits & PROXY else "border" if bits & BORDER else "member" if bits & MEMBER else "asleep" if bits & ASLEEP
            else "awake")


class InPage(in_browser.BrowserTest):
    def open(self, viewer, state="live: "):
        self.browser.get("about:blank")
        self.browser.get_log("browser")
        self.browser.get(viewer.address)
        wait_for(lambda: self.text("state").startswith(state), f"page, which says '{self.text('state')}'")

    def canvas(self):
        return self.browser.execute_script("return {...document.getElementById('canvas').dataset}")

    def choose(self, selector, value):
        self.browser.execute_script(
            "const e = document.querySelector(arguments[0]); if (e.type === 'radio') e.checked = true; else e.value = arguments[1];"
            " e.dispatchEvent(new Event('change'))", selector, value)

    def logged(self):
        return [line["message"] for line in self.browser.get_log("browser")]

    def look(self, bodies):
        """What they are drawn as: colour, edges' colour, seen through; None: left out."""
        found = self.browser.execute_script(
            "const canvas = document.getElementById('canvas'); return arguments[0].map((body) => canvas.look(body))", bodies)
        return [one and (one["colour"], one["edge"], one["see_through"]) for one in found]

    def pause(self, published):
        """Of a run in virtual time: the controller's newest frame, which is drawn."""
        self.browser.execute_script("document.querySelector('[data-time=play]').click()")
        wait_for(lambda: self.text("answer") == "paused", "pause")
        return wait_for(lambda: (frame := published.standing()) and float(self.canvas()["world_s"]) == frame[0] and frame, "same frame")

    def compare_poses(self, moving, bodies, indices):
        for index in indices:
            drawn = self.browser.execute_script("return document.getElementById('canvas').drawn(arguments[0])", moving[index])
            self.assertIsNotNone(drawn, moving[index])
            (place, (w, x, y, z)), turn = bodies[index], drawn[3:]
            for a, b in zip(place, drawn):
                self.assertAlmostEqual(a, b, delta=PLACE_M)
            off = min(max(abs(a - sign * b) for a, b in zip((x, y, z, w), turn)) for sign in (1, -1))
            self.assertLess(off, TURN)

    def compare_roles(self, moving, roles):
        """Each is drawn as what the controller says it is. Returns the kinds that there were."""
        kinds = [kind_of(bits) for bits in roles]
        shown = list(range(len(moving)))
        if len(shown) > MOST_BODIES:
            few = len(shown) // MOST_BODIES
            shown = [i for i in shown if roles[i] & (MEMBER | PROXY) or i % few == 0]
        for i, look in zip(shown, self.look([moving[i] for i in shown])):
            self.assertEqual(look, LOOKS[kinds[i]], f"body {moving[i]}, {kinds[i]}")
        return set(kinds)

    def graph(self, name):
        return set(self.browser.execute_script(
            "return [...document.querySelectorAll(`#graph [${arguments[0]}]`)].map((e) => e.getAttribute(arguments[0]))", name))


class Poses(InPage):
    def test_bodies_are_drawn_where_the_controller_has_them(self):
        folder = tempfile.mkdtemp(prefix="tactus-poses-")
        self.addCleanup(shutil.rmtree, folder, True)
        control = os.path.join(folder, "c.sock")
        run = ViewedRun(PROGRAM, "run", CARDS, "--view", "--virtual-time", "--pace", "0", "--control", control)
        self.addCleanup(run.kill)
        self.open(run)
        published = Published(control)
        self.addCleanup(published.close)
        page = Page(run)
        scene = json.loads(page.message())
        page.close()
        moving = [i for i, body in enumerate(scene["bodies"]) if not body["fixed"]]
        starts = [scene["bodies"][i]["position"] for i in moving]
        self.assertEqual(published.bodies, len(moving))
        far = lambda frame: max(max(abs(a - b) for a, b in zip(start, place)) for start, (place, _) in zip(starts[1:], frame[1][1:]))  # noqa: E731
        wait_for(lambda: (frame := published.frame()) and far(frame) > 0.01, "card that has moved by a centimetre")
        time_s, bodies, roles = wait_for(lambda: self.pause_with_member(published), "member")
        self.compare_poses(moving, bodies, range(0, len(moving), 2))
        self.assertLessEqual({"proxy", "member"}, self.compare_roles(moving, roles))
        self.assertGreater(time_s, 0)
        self.assertEqual(self.logged(), [])

    def pause_with_member(self, published):
        """As pause, if a body beside the proxy is drawn as a member there; otherwise plays on: how far the run is by then depends on the machine."""
        frame = self.pause(published)
        if any(kind_of(bits) == "member" for bits in frame[2]):
            return frame
        self.browser.execute_script("document.querySelector('[data-time=play]').click()")
        wait_for(lambda: self.text("answer") != "paused", "end of the pause")
        return None


class Stall(InPage):
    def test_a_stall_of_the_haptic_thread_is_caught_with_the_ticks_before_and_after_it(self):
        """The whole run stands still, and so the thread wakes late. Other stalls of this machine are as long by chance alone."""
        stood_us = 300_000
        run = Run(PROGRAM, "card_house.toml")
        self.addCleanup(run.end)
        viewer = Viewer(run)
        self.addCleanup(viewer.end)
        self.open(viewer)
        wait_for(lambda: self.text("time") not in ("–", ""), "tick")
        self.choose("#signal", "5")  # the whole tick
        self.choose("#window", "1")
        self.choose("#level", str(stood_us))
        self.choose("#trigger", "level")
        began = float(self.text("time"))
        wait_for(lambda: float(self.text("time")) > began + 0.5, "ticks before")
        self.choose("input[name=mode][value=trigger]", "")
        wait_for(lambda: self.text("caught") == "waiting", "armed trigger")
        run.process.send_signal(signal.SIGSTOP)
        time.sleep(2e-6 * stood_us)
        run.process.send_signal(signal.SIGCONT)
        wait_for(lambda: "750 ticks since" in self.text("caught"), "stall")
        at_s = float(self.text("caught").split()[2])
        rows = self.saved_rows()
        whole = [float(row["wake_to_written_us"]) for row in rows]
        at = next(i for i, value in enumerate(whole) if value > stood_us)
        self.assertAlmostEqual(float(rows[at]["time_s"]), at_s, delta=1e-6 + 0.0005)
        self.assertEqual((at, len(rows)), (250, 1000))  # a quarter of the window before it
        self.assertLess(max(whole[:at]), stood_us)
        self.assertGreater(int(self.text("overruns")), 0)

    @long
    def test_b_a_stall_of_the_world_is_caught_by_what_the_force_does(self):
        """For 0.3 s no snapshot comes: after 0.1 s without one the force fades, and comes back with the next. Virtual time."""
        run = ViewedRun(PROGRAM, "view", os.path.join(SCENES, "press.toml"), "--virtual-time", "--inject", "stall@1500+300", "--pace", "0.02")
        self.addCleanup(run.kill)
        self.open(run)
        pace = lambda: self.browser.execute_script("return document.getElementById('pace').value")  # noqa: E731
        wait_for(lambda: pace() == "0.02", "pace of the command line")
        self.choose("#window", "1")
        self.choose("#level", "0.2")  # N a tick: pressing and sliding stay below 0.05
        self.choose("#trigger", "step")
        self.choose("input[name=mode][value=trigger]", "")
        self.choose("#pace", "3")
        wait_for(lambda: "750 ticks since" in self.text("caught"), "stall")
        at_s = float(self.text("caught").split()[2])
        self.assertTrue(1.6 < at_s < 1.63, at_s)
        rows = self.saved_rows()
        force = [float(row["size_N"]) for row in rows]
        self.assertEqual(len(rows), 1000)
        self.assertAlmostEqual(float(rows[250]["time_s"]), at_s, delta=0.0006)
        self.assertGreater(min(force[:250]), 2)
        self.assertEqual(min(force[250:]), 0)
        self.assertGreater(force[-1], 1)

    @long
    def test_c_a_level_waits_for_a_crossing(self):
        """Armed above the level; the stall of the world takes the force away, and its return is the crossing."""
        run = ViewedRun(PROGRAM, "view", os.path.join(SCENES, "press.toml"), "--virtual-time", "--inject", "stall@1500+300", "--pace", "0.01")
        self.addCleanup(run.kill)
        self.open(run)
        self.choose("#window", "1")
        self.choose("#level", "1")
        self.choose("#trigger", "level")
        self.choose("#pace", "0.1")
        wait_for(lambda: self.text("force") != "–" and float(self.text("force")) > 2, "force above the level")
        play = "document.querySelector('[data-time=play]').click()"
        self.browser.execute_script(play)
        wait_for(lambda: self.text("answer") == "paused", "pause")
        self.assertLess(float(self.text("time")), 1.5)
        self.choose("input[name=mode][value=trigger]", "")
        self.browser.execute_script(play)
        self.choose("#pace", "3")
        wait_for(lambda: "750 ticks since" in self.text("caught"), "return of the force")
        at_s = float(self.text("caught").split()[2])
        self.assertTrue(1.8 < at_s < 1.9, at_s)
        force = [float(row["size_N"]) for row in self.saved_rows()]
        self.assertLessEqual(force[249], 1)
        self.assertGreater(force[250], 1)

    def saved_rows(self):
        """What the plot's button would save."""
        self.browser.execute_script(
            "window.saved = null; URL.createObjectURL = (blob) => (blob.text().then((text) => (window.saved = text)), '#')")
        self.browser.execute_script("document.getElementById('csv').click()")
        return list(csv.DictReader(wait_for(lambda: self.browser.execute_script("return window.saved"), "CSV").splitlines()))


@long
class Hands(InPage):
    """Two hands: a page for each."""

    def test_each_page_is_a_hand_s_and_tells_the_other_s_proxy_apart(self):
        run = ViewedRun(PROGRAM, "run", TWO_HANDS, "--virtual-time", "--view", "--pace", "1")
        self.addCleanup(run.kill)
        lines = {run.line: run.address}
        second = run.viewer_line()
        lines[run.line] = second
        self.assertEqual(sorted(line.split("http://")[0] for line in lines), [f"tactus view: hand {hand} of 2: " for hand in (1, 2)])
        proxies = set()
        for line, address in sorted(lines.items()):
            self.browser.get("about:blank")
            self.browser.get(address)
            wait_for(lambda: int(self.canvas().get("solid", 0)) >= 2, "bodies")
            self.assertIn(line.split(": ")[1], self.text("title"))
            port, token = int(address.split(":")[2].split("/")[0]), address.split("#")[1]
            page = Page(SimpleNamespace(port=port, token=token))
            scene = json.loads(page.message())
            page.close()
            other, = scene["other_proxies"]
            self.assertNotEqual(scene["proxy"], other)
            proxies |= {scene["proxy"]}
            self.assertEqual(self.look([scene["proxy"], other]), [LOOKS["proxy"], LOOKS["other"]])
            self.assertIn("proxy of another hand", self.text("legend"))
        self.assertEqual(proxies, {scene["proxy"], other})


@long
class Hidden(InPage):
    """A page that nobody sees."""

    def test_it_takes_nothing_until_it_is_seen_again(self):
        run = Run(PROGRAM, "card_house.toml")
        self.addCleanup(run.end)
        viewer = Viewer(run)
        self.addCleanup(viewer.end)
        self.open(viewer)
        taken = lambda: self.browser.execute_script("return document.getElementById('canvas').taken()")  # noqa: E731
        hidden = lambda: self.browser.execute_script("return document.hidden")  # noqa: E731
        ticks = lambda: run.ask("state")["ticks"]  # noqa: E731
        wait_for(lambda: taken() > 3, "frames")
        size = self.browser.get_window_size()
        self.browser.minimize_window()
        wait_for(hidden, "hidden page")
        at_most = taken() + 2  # those that are on their way
        before = ticks()
        wait_for(lambda: ticks() > before + 1000, "ticks")
        self.assertLessEqual(taken(), at_most)
        stands = taken()
        wait_for(lambda: ticks() > before + 1500, "ticks")
        self.assertEqual(taken(), stands)
        self.browser.set_window_size(size["width"], size["height"])
        wait_for(lambda: not hidden() and taken() > stands + 3, "frames again")


@long
class Ended(InPage):
    def test_nothing_can_be_asked_of_a_run_that_was_killed(self):
        run = Run(PROGRAM, "card_house.toml")
        self.addCleanup(shutil.rmtree, run.folder, True)
        viewer = Viewer(run)
        self.addCleanup(viewer.end)
        self.open(viewer)
        active = lambda: self.browser.execute_script(  # noqa: E731
            "return [...document.querySelectorAll('[data-ask], [data-time], #take, #pace')].filter((e) => !e.disabled).length")
        self.assertGreater(active(), 8)
        run.process.kill()
        run.process.communicate()
        wait_for(lambda: self.text("state") == "the run is over", "end")
        self.assertEqual(active(), 0)


class EveryScene(InPage):
    """Each is drawn, all of its bodies, in few calls, in more than one colour, where and as what the controller has them, with the
    graph of its contacts, and nothing is logged."""

    def test_scenes(self):
        names = sorted(name for name in os.listdir(SCENES) if name.endswith(".toml"))
        self.assertGreater(len(names), 15)
        if not LONG:  # each kind of shape, asked for below
            names = ["cups.toml", "stones.toml", "terrain.toml", "wall.toml"]
        kinds, drawn_as = set(), set()
        folder = tempfile.mkdtemp(prefix="tactus-scenes-")
        self.addCleanup(shutil.rmtree, folder, True)
        for number, name in enumerate(names):
            with self.subTest(scene=name):
                control = os.path.join(folder, f"{number}.sock")
                run = ViewedRun(PROGRAM, "view", os.path.join(SCENES, name), "--virtual-time", "--pace", "0.01", "--control", control)
                self.addCleanup(run.kill)
                page = Page(run)
                scene = json.loads(page.message())
                page.close()
                moving = [i for i, body in enumerate(scene["bodies"]) if not body["fixed"]]
                kinds |= {shape["kind"] for shape in scene["shapes"]}
                self.open(run)
                wait_for(lambda: int(self.canvas().get("solid", 0)) + int(self.canvas().get("outside", 0)) == len(moving), f"{len(moving)} bodies")
                wait_for(lambda: int(self.canvas().get("calls", 0)) > 0, "picture")
                self.assertLessEqual(int(self.canvas()["calls"]), 60)
                self.assertGreater(wait_for(self.colours, "colours"), 5)
                published = Published(control)
                _, bodies, roles = self.pause(published)
                published.close()
                self.compare_poses(moving, bodies, range(0, len(moving), -(-len(moving) // 10)))
                drawn_as |= self.compare_roles(moving, roles)
                edges, nodes, unlinked = graph_of(run)
                wait_for(lambda: (self.graph("data-edge"), self.graph("data-body")) == (edges, nodes), f"graph {edges}")
                self.assertEqual(self.text("unlinked")[-len(str(unlinked)):], str(unlinked) if unlinked else "")
                self.assertEqual(self.logged(), [])
                run.end()
        self.assertLessEqual({"proxy", "member", "awake"}, drawn_as)
        self.assertEqual(kinds, {"sphere", "capsule", "box", "plane", "mesh", "compound"})

    def colours(self):
        """Of the picture, in the frame in which it is drawn: WebGL forgets it afterwards."""
        return self.browser.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => {"
            " const c = document.getElementById('canvas'), p = document.createElement('canvas'); p.width = p.height = 64;"
            " const x = p.getContext('2d'); x.drawImage(c, 0, 0, 64, 64); const d = x.getImageData(0, 0, 64, 64).data, s = new Set();"
            " for (let i = 0; i < d.length; i += 4) s.add((d[i] << 16) | (d[i + 1] << 8) | d[i + 2]); done(s.size) }))")


class Figures(InPage):
    def check(self):
        found = self.browser.execute_script(
            "const out = {}; for (const e of document.querySelectorAll('output'))"
            " out[e.id] = e.parentElement.textContent.replace(/\\s+/g, ' ').trim(); return out")
        self.assertEqual(set(found), set(FIGURES))
        for name, text in found.items():
            self.assertRegex(text, FIGURES[name], name)

    def check_plots(self):
        options = self.browser.execute_script("return [...document.querySelectorAll('#signal option')].map((e) => e.textContent)")
        self.assertEqual(options, list(UNITS))
        for number, (name, unit) in enumerate(UNITS.items()):
            self.choose("#signal", str(number))
            labels = self.browser.execute_script("return [...document.querySelectorAll('#plot .u-legend .u-label')].map((e) => e.textContent)")
            self.assertEqual(labels[0], "t [s]")
            self.assertGreater(len(labels), 1)
            for label in labels[1:]:
                if unit is None:  # counts
                    self.assertNotIn("[", label)
                else:
                    self.assertTrue(label.endswith(f"[{unit}]"), f"{name}: {label}")

    def test_1_of_a_run_before_and_after_its_first_ticks(self):
        run = Run(PROGRAM, "card_house.toml")
        self.addCleanup(run.end)
        viewer = Viewer(run)
        self.addCleanup(viewer.end)
        self.open(viewer)
        self.check()
        wait_for(lambda: self.text("time") != "–" and self.text("share") != "–" and not self.text("verdict").startswith("–"), "figures")
        self.check()
        self.check_plots()
        self.choose("#level", "0.001")
        self.choose("#signal", "0")
        self.choose("input[name=mode][value=trigger]", "")
        wait_for(lambda: self.text("caught") != "", "trigger")
        self.check()

    @long
    def test_2_of_a_tape(self):
        folder = tempfile.mkdtemp(prefix="tactus-figures-")
        self.addCleanup(shutil.rmtree, folder, True)
        tape = os.path.join(folder, "a.tape")
        subprocess.run([PROGRAM, "run", CARDS, "--virtual-time", "--duration", "1", "--record", tape], check=True, capture_output=True)
        viewer = TapeViewer(PROGRAM, tape)
        self.addCleanup(viewer.end)
        self.open(viewer, "tape: ")
        wait_for(lambda: self.text("time") != "–", "figures")
        self.check()
        self.check_plots()


if __name__ == "__main__":
    in_browser.PROGRAM = PROGRAM
    if (why := in_browser.missing()) is not None:
        skip(why)
    sys.exit(0 if unittest.main(exit=False).result.wasSuccessful() else 1)
