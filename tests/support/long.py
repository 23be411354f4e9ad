"""Which tests take long: only tools/check --long runs them, as tests of their own that have TACTUS_LONG."""
import os
import unittest

LONG = bool(os.environ.get("TACTUS_LONG"))
long = unittest.skipUnless(LONG, "tools/check --long runs it")
