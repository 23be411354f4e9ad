"""A page in Chromium, by Debian's chromium-driver and python3-selenium: wide and narrow, light, dark and printed."""
import os
import shutil
import tempfile

CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"
LIGHT, DARK = "rgb(255, 255, 255)", "rgb(20, 23, 26)"
# name: (width in px, the screen's scheme, medium, the paper it must have). 718 px: A4 less its margins.
VIEWS = {"wide, light": (1200, "light", "screen", LIGHT), "wide, dark": (1200, "dark", "screen", DARK),
         "narrow, light": (400, "light", "screen", LIGHT), "narrow, dark": (400, "dark", "screen", DARK),
         "printed": (718, "dark", "print", LIGHT)}
CHECKS = open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "checks.js"), encoding="utf-8").read()


def missing():
    """What this machine lacks, or nothing."""
    if not os.path.exists(CHROMIUM) or not os.path.exists(DRIVER):
        return "no chromium with its driver (Debian: chromium, chromium-driver)"
    try:
        import selenium  # noqa: F401
    except ImportError:
        return "no selenium (Debian: python3-selenium)"
    return None


class Browser:
    def __enter__(self):
        from selenium import webdriver
        from selenium.common.exceptions import WebDriverException
        from selenium.webdriver.chrome.options import Options
        from selenium.webdriver.chrome.service import Service
        self.profile = tempfile.mkdtemp()
        options = Options()
        options.binary_location = CHROMIUM
        for word in ("headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-background-networking",
                     "disable-component-update", "disable-sync", "disable-dev-shm-usage", "hide-scrollbars",
                     f"user-data-dir={self.profile}"):
            options.add_argument("--" + word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        for tries_left in (2, 1, 0):  # a busy machine may need longer than the driver waits
            try:
                self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
                break
            except WebDriverException:
                if tries_left == 0:
                    raise
        self.driver.set_page_load_timeout(300)  # a busy machine
        self.driver.set_script_timeout(300)
        return self

    def __exit__(self, *_):
        self.driver.quit()
        shutil.rmtree(self.profile, ignore_errors=True)

    def open(self, path):
        self.driver.get("file://" + os.path.abspath(path))

    def show(self, view):
        width, scheme, medium, _ = VIEWS[view]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                                    {"media": medium, "features": [{"name": "prefers-color-scheme", "value": scheme}]})
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})

    def problems(self, view, kind):
        """All that is wrong in this view, and what the console said since the last call."""
        self.show(view)
        found = self.driver.execute_script(CHECKS, kind, VIEWS[view][3])
        return found + [f"console: {line['message']}" for line in self.driver.get_log("browser") if line["level"] != "INFO"]
