#!/usr/bin/python3
"""tests/tools/pages/pages_test.py PROGRAM: each page and the plot of `tactus timing`, looked at in Chromium.

Every page of made.py and those of quick runs of PROGRAM, in every view of browser.py, by every check of checks.js; then one
defect for each check, which must see it. Exit 77 where there is no Chromium or no matplotlib.
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
WRITER = os.path.join(HERE, "..", "..", "..", "tools", "experiment_page")
sys.path.insert(0, HERE)
import browser
import made

PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else ""
# Of the program itself, so that what it writes and what the pages read are the same: the options of `tactus`, and the file.
RUNS = {"energy-loss of the program": (["experiment", "energy-loss", "--quick", "--scenes", "stack", "--borders", "ghost",
                                        "--ratios", "8", "--whole", "1", "--page"], "energy.html"),
        "accuracy-cost of the program": (["experiment", "accuracy-cost", "--quick", "--scenes", "stack", "--page"], "cost.html"),
        "capacity of the program": (["experiment", "capacity", "--quick", "--most", "50", "--page"], "capacity.html"),
        "timing of the program": (["timing", "--duration", "3", "--svg"], "timing.svg")}

# A defect for each check, as a script that makes it in the page "couplings" or in the plot.
DEFECTS = {
    "overflow": "document.body.insertAdjacentHTML('beforeend', '<div style=\"width:2000px;height:1px\"></div>')",
    "clipped": "document.querySelector('figure svg[role=img] text').setAttribute('x', '-40')",
    "small": "document.querySelector('figure svg[role=img] text').style.fontSize = '3px'",
    "overprint": "{const t = document.querySelectorAll('g.ytick text'); for (const a of ['x', 'y', 'transform'])"
                 " t[1].setAttribute(a, t[0].getAttribute(a) || '');}",
    "letter": "{const m = [...document.querySelectorAll('figure svg[role=img] use')].find((u) => !u.closest('g.axis'));"
              " const g = m.parentNode.appendChild(document.createElementNS('http://www.w3.org/2000/svg', 'g'));"
              " const t = g.appendChild(document.createElementNS('http://www.w3.org/2000/svg', 'text')); g.id = 'label';"
              " t.textContent = 'A'; t.style.fontSize = '9px'; t.setAttribute('x', m.getAttribute('x'));"
              " t.setAttribute('y', m.getAttribute('y'));}",
    "far-letter": "{const s = document.querySelector('figure svg[role=img]');"
                  " const g = s.appendChild(document.createElementNS('http://www.w3.org/2000/svg', 'g'));"
                  " const t = g.appendChild(document.createElementNS('http://www.w3.org/2000/svg', 'text')); g.id = 'label';"
                  " t.textContent = 'A'; t.style.fontSize = '9px'; t.setAttribute('x', 2); t.setAttribute('y', 12);}",
    "units": "document.querySelectorAll('g.axis > g.text text').forEach((t) => t.textContent = 'force error')",
    "ticks": "{const t = document.querySelectorAll('g.ytick text'); [t[0].textContent, t[1].textContent] ="
             " [t[1].textContent, t[0].textContent];}",
    "hidden": "{const s = document.querySelectorAll('figure svg[role=img]')[0].querySelectorAll('[data-series]');"
              " s[1].innerHTML = s[0].innerHTML;}",
    "legend": "document.querySelector('.legend li').remove()",
    "contrast": "document.querySelector('figcaption').style.color = '#808488'",
    "digits": "document.querySelector('td').textContent = '31492788971.07 %'",
    "paper": "document.body.style.background = '#eeeeee'",
    "answer": "document.querySelector('.answer').remove()",
    "provenance": "document.querySelector('.made dd').textContent = ''",
    "columns": "document.querySelector('dl.columns dt').remove()",
    "network": "document.body.insertAdjacentHTML('beforeend', '<img src=https://example.org/a.png loading=lazy hidden>')",
    "columns-hidden": "document.querySelector('table.few').style.width = '3000px'",
    "console": "console.error('a defect')"}
PLOT_DEFECTS = {
    "unit": "document.querySelector('.made').textContent += ' 12'",
    "limit": "{const c = getComputedStyle(document.querySelector('[data-series]')).stroke;"
             " document.querySelectorAll('.limit').forEach((e) => e.style.stroke = c);}"}


def write_page(experiment, data, path):
    given = json.dumps({"made": made.MADE, "data": data})
    subprocess.run([sys.executable, WRITER, experiment, path], input=given, text=True, check=True)


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = cls.enterClassContext(tempfile.TemporaryDirectory())
        cls.browser = cls.enterClassContext(browser.Browser())

    def look_at(self, path, kind):
        self.browser.open(path)
        for view in browser.VIEWS:
            with self.subTest(view=view):
                self.assertEqual(self.browser.problems(view, kind), [])

    def test_pages_of_made_data(self):
        for name, (experiment, data) in made.PAGES.items():
            with self.subTest(page=name):
                path = os.path.join(self.folder, "made.html")
                write_page(experiment, data(), path)
                self.look_at(path, "page")

    def test_pages_and_plot_of_the_program(self):
        for name, (options, file) in RUNS.items():
            with self.subTest(page=name):
                path = os.path.join(self.folder, file)
                ran = subprocess.run([PROGRAM, *options, path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                self.assertIn(ran.returncode, (0, 1), ran.stdout)  # 1: bad by the verdict, which this machine may be
                self.look_at(path, "plot" if file.endswith(".svg") else "page")

    def test_each_check_sees_its_defect(self):
        path = os.path.join(self.folder, "good.html")
        experiment, data = made.PAGES["couplings"]
        write_page(experiment, data(), path)
        self.browser.open(path)
        self.assertEqual(self.browser.problems("wide, light", "page"), [])
        for check, defect in DEFECTS.items():
            with self.subTest(check=check):
                self.browser.open(path)
                self.browser.driver.execute_script(defect)
                found = {line.split(":")[0] for line in self.browser.problems("wide, light", "page")}
                self.assertIn(check, found)

    def test_each_check_of_the_plot_sees_its_defect(self):
        path = os.path.join(self.folder, "good.svg")
        subprocess.run([PROGRAM, "timing", "--duration", "3", "--svg", path], stdout=subprocess.DEVNULL)
        for check, defect in PLOT_DEFECTS.items():
            with self.subTest(check=check):
                self.browser.open(path)
                self.browser.driver.execute_script(defect)
                found = {line.split(":")[0] for line in self.browser.problems("wide, light", "plot")}
                self.assertIn(check, found)

    def test_a_wide_table_is_seen_where_it_is_printed(self):
        path = os.path.join(self.folder, "good.html")
        experiment, data = made.PAGES["couplings"]
        write_page(experiment, data(), path)
        self.browser.open(path)
        self.browser.driver.execute_script("document.querySelector('table').style.width = '900px'")
        self.assertEqual(self.browser.problems("wide, light", "page"), [])  # there it scrolls
        self.assertTrue(any("printed, a table" in line for line in self.browser.problems("printed", "page")))


def main():
    why = browser.missing()
    if why is None and subprocess.run([sys.executable, "-c", "import matplotlib"], stderr=subprocess.DEVNULL).returncode != 0:
        why = "no matplotlib (Debian: python3-matplotlib)"
    if why is not None:
        print(f"tactus-skipped: {why}")
        return 77
    return 0 if unittest.main(exit=False).result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
