#!/usr/bin/python3
"""tests/tools/view/in_browser.py PROGRAM: the page of tactus view in Chromium shows what the run has. It begins with the proof
that WebGL draws; speed is not judged. Exit 77 where there is no browser or no page."""
import http.server
import os
import shutil
import sys
import threading
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from watched_run import Run, Viewer, page_is_built, skip, wait_for  # noqa: E402

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else ""
# Software rendering: Chromium does not fall back to it by itself.
FLAGS = ["--headless=new", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--window-size=1400,900"]


def open_browser():
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in FLAGS + (["--no-sandbox"] if os.geteuid() == 0 else []):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)


class BrowserTest(unittest.TestCase):
    """Tests that share a browser, each with a run of its own."""

    @classmethod
    def setUpClass(cls):
        cls.browser = open_browser()

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()

    def text(self, name):
        return self.browser.execute_script("return document.getElementById(arguments[0]).textContent", name)


class Blank(http.server.BaseHTTPRequestHandler):
    """An empty page."""

    def do_GET(self):
        self.send_response(200)
        self.end_headers()

    def log_message(self, *words):
        pass


class InBrowser(unittest.TestCase):
    scene, moving = "card_house.toml", 27

    @classmethod
    def setUpClass(cls):
        cls.run_ = Run(PROGRAM, cls.scene)
        cls.viewer = Viewer(cls.run_)
        cls.browser = open_browser()
        cls.browser.get(cls.viewer.address)
        cls.shows("state", "live: real time cannot be paused")
        wait_for(lambda: cls.text("time") != "–", "tick")

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.viewer.end()
        cls.run_.end()

    @classmethod
    def text(cls, name):
        return cls.browser.execute_script("return document.getElementById(arguments[0]).textContent", name)

    @classmethod
    def shows(cls, name, text):
        wait_for(lambda: cls.text(name) == text, f"'{text}' as {name}, which has '{cls.text(name)}'")

    def canvas(self):
        return self.browser.execute_script("return {...document.getElementById('canvas').dataset}")

    def choose(self, selector, value):
        self.browser.execute_script(
            "const e = document.querySelector(arguments[0]); if (e.type === 'radio' || e.type === 'checkbox') e.checked = arguments[1];"
            " else e.value = arguments[1]; e.dispatchEvent(new Event('change', {bubbles: true}));"
            " e.dispatchEvent(new Event('input', {bubbles: true}))", selector, value)

    def test_1_webgl_draws_a_picture_of_more_than_one_colour(self):
        renderer = self.browser.execute_script(
            "const g = document.getElementById('canvas').getContext('webgl2'); return g && g.getParameter(g.VERSION)")
        self.assertIn("WebGL 2", renderer or "")
        colours = self.browser.execute_script(
            "const c = document.getElementById('canvas'), p = document.createElement('canvas'); p.width = 64; p.height = 64;"
            " const x = p.getContext('2d'); x.drawImage(c, 0, 0, 64, 64); const d = x.getImageData(0, 0, 64, 64).data;"
            " const s = new Set(); for (let i = 0; i < d.length; i += 4) s.add((d[i] << 16) | (d[i + 1] << 8) | d[i + 2]);"
            " return s.size")
        self.assertGreater(colours, 20)
        self.assertLessEqual(int(self.canvas()["calls"]), 60)

    def test_2_every_body_is_drawn_by_its_role_and_layers_leave_them_out(self):
        wait_for(lambda: int(self.canvas().get("solid", 0)) + int(self.canvas()["outside"]) == self.moving, "bodies")
        members = int(self.text("members").split("/")[0])
        self.assertGreater(members, 0)
        self.choose("#layers [name=members]", False)
        wait_for(lambda: self.canvas()["solid"] == "0", "picture without members")
        self.choose("#layers [name=members]", True)
        wait_for(lambda: int(self.canvas()["solid"]) > 0, "members")
        wait_for(lambda: int(self.canvas()["arrows"]) > 0, "contact forces")
        self.choose("#layers [name=forces]", False)
        wait_for(lambda: self.canvas()["arrows"] == "0", "picture without arrows")
        self.choose("#layers [name=forces]", True)

    def test_3_figures_are_text_and_time_goes_on(self):
        first = float(self.text("time"))
        wait_for(lambda: float(self.text("time")) > first + 0.5, "later time")
        self.assertRegex(self.text("members"), r"^\d+/\d+$")
        self.assertRegex(self.text("force"), r"^\d+\.\d\d$")
        self.assertEqual(self.text("fault"), "none")
        self.assertIn("sub-world/ghost · r=10 · T=1 ms", self.text("title"))
        wait_for(lambda: self.text("share") != "–", "share of real time")

    def test_4_the_graph_has_its_bodies_once_and_edges_between_them(self):
        nodes, edges = wait_for(lambda: self.graph(), "graph")
        self.assertEqual(len(nodes), len(set(nodes)))
        self.assertEqual(nodes.count("0"), 1)  # the proxy
        for edge in edges:
            a, b = edge.split(",")
            self.assertTrue(a in nodes and b in nodes, edge)
            self.assertNotEqual(a, b)

    def graph(self):
        nodes, edges = self.browser.execute_script(
            "const all = (name) => [...document.querySelectorAll(`#graph [${name}]`)].map((e) => e.getAttribute(name));"
            " return [all('data-body'), all('data-edge')]")
        return (nodes, edges) if nodes and edges else None

    def test_5_a_trigger_holds_the_plot_with_the_ticks_before_it(self):
        self.choose("#window", "1")
        self.choose("#level", "0.01")
        self.choose("#trigger", "level")  # before the mode: else the trigger chosen before may fire first
        self.choose("input[name=mode][value=trigger]", True)
        caught = wait_for(lambda: self.text("caught").startswith("caught at") and self.text("caught"), "force")
        at = float(caught.split()[2])
        wait_for(lambda: float(self.text("time")) > at + 1.5, "ticks after it")
        self.assertEqual(float(self.text("caught").split()[2]), at)  # single: it stays
        self.assertIn("750 ticks since", self.text("caught"))  # three quarters of the window
        self.choose("input[name=mode][value=roll]", True)
        wait_for(lambda: self.text("caught") == "", "rolling plot")

    def test_6_hovering_a_body_in_the_graph_names_it(self):
        self.browser.execute_script(
            "document.querySelector('#graph [data-body=\"0\"]').dispatchEvent(new PointerEvent('pointerover', {bubbles: true}))")
        wait_for(lambda: self.text("hover").startswith("the proxy") and "proxy, member" in self.text("hover"), "name")

    def test_7_nothing_is_logged_and_a_wrong_token_sees_nothing(self):
        self.assertEqual([line["message"] for line in self.browser.get_log("browser")], [])
        self.browser.execute_script("window.open('about:blank')")
        self.browser.switch_to.window(self.browser.window_handles[1])
        self.browser.get(self.viewer.address[:-1] + ("1" if self.viewer.address[-1] == "0" else "0"))
        wait_for(lambda: self.text("state").startswith("not connected"), "refusal")
        self.browser.close()
        self.browser.switch_to.window(self.browser.window_handles[0])

    def test_7b_a_page_of_another_origin_can_neither_connect_nor_read(self):
        """Also with the right token; the same from the page's own origin, so that it is the origin that is refused."""
        try_both = (
            "const [port, token, done] = arguments, at = `127.0.0.1:${port}`, said = {};"
            " const read = fetch(`http://${at}/`).then((r) => r.text()).then((t) => (said.read = t.length > 0), () => (said.read = false));"
            " const connect = new Promise((end) => { const socket = new WebSocket(`ws://${at}/run`, ['tactus', token]);"
            " socket.onmessage = () => { said.connected = true; socket.close(); end() }; socket.onclose = () => { said.connected ??= false; end() } });"
            " Promise.all([read, connect]).then(() => done(said))")
        arguments = try_both, self.viewer.port, self.viewer.token
        self.assertEqual(self.browser.execute_async_script(*arguments), {"read": True, "connected": True})
        other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Blank)
        threading.Thread(target=other.serve_forever, daemon=True).start()
        self.browser.execute_script("window.open('about:blank')")
        self.browser.switch_to.window(self.browser.window_handles[1])
        self.browser.get(f"http://127.0.0.1:{other.server_port}/")
        self.assertEqual(self.browser.execute_async_script(*arguments), {"read": False, "connected": False})
        self.browser.close()
        self.browser.switch_to.window(self.browser.window_handles[0])
        other.shutdown()
        other.server_close()
        self.browser.get_log("browser")  # that it was refused: read, so that it is no surprise later

    def test_8_buttons_reach_the_run(self):
        self.browser.execute_script("document.querySelector('[data-ask=disarm]').click()")
        wait_for(lambda: "disarmed" in self.text("answer"), "answer")
        wait_for(lambda: not self.run_.ask("state")["armed"], "disarmed run")
        self.browser.execute_script("document.querySelector('[data-ask=stop]').click()")
        self.shows("state", "the run is over")


def missing():
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "no selenium (Debian: python3-selenium)"
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return f"no {program} (Debian: chromium, chromium-driver)"
    return None if page_is_built(PROGRAM) else "the page is not built: no node or npm"


if __name__ == "__main__":
    if (why := missing()) is not None:
        skip(why)
    sys.exit(0 if unittest.main(exit=False).result.wasSuccessful() else 1)
