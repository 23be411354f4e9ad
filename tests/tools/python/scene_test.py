#!/usr/bin/python3
"""tests/tools/python/scene_test.py PROGRAM FOLDER: tactus.Scene against the loader."""
import glob
import os
import pickle
import subprocess
import sys
import tempfile
import tomllib
import unittest
from copy import deepcopy

import bench
import numpy as np
import tactus
from tactus.toml_text import toml_text

SMALL = {
    "effects": ["gravity", "friction"],
    "proxy": {"shape": "sphere", "radius_m": 0.01, "mass_kg": 0.2, "position_m": [0, 0, 0.115]},
    "body": [{"shape": "plane", "friction": 0.5},
             {"shape": "box", "size_m": [0.1, 0.1, 0.1], "mass_kg": 1, "friction": 0.5, "position_m": [0, 0, 0.05]}],
}


class Scenes(unittest.TestCase):
    def test_every_scene_is_saved_and_loads_to_the_same_bits(self):
        with tempfile.TemporaryDirectory() as folder:
            for path in sorted(glob.glob(os.path.join(bench.SCENES, "*.toml"))):
                name = os.path.basename(path)[:-5]
                if name in ("heaps50k", "pile5000"):  # as pile700, for minutes
                    continue
                with self.subTest(scene=name):
                    saved = os.path.join(folder, name + ".toml")
                    tactus.Scene(path).save(saved)
                    first, second = tactus.Session(path), tactus.Session(saved)
                    first.step(120)
                    second.step(120)
                    self.assertEqual(first.state_hash, second.state_hash)
                    self.assertTrue(np.array_equal(first.position, second.position))

    def test_a_scene_of_keys_is_the_text_of_these_keys(self):
        scene = tactus.Scene(SMALL)
        self.assertEqual(scene.check(), [])
        self.assertEqual(tomllib.loads(scene.text), SMALL)
        session = tactus.Session(SMALL)
        session.step(400)
        other = tactus.Session(tactus.Scene(text=scene.text))
        other.step(400)
        self.assertEqual(session.state_hash, other.state_hash)

    def test_keys_are_changed_as_in_a_mapping(self):
        scene = tactus.Scene(bench.scene("press"))
        self.assertIn("proxy", scene)
        self.assertEqual(len(scene), len(list(scene)))
        copy = tactus.Scene(scene)
        copy["proxy"]["mass_kg"] = np.float64(0.3)
        self.assertNotEqual(scene["proxy"]["mass_kg"], 0.3)
        self.assertEqual(tactus.Session(copy).bodies[0]["mass_kg"], 0.3)
        for other in (deepcopy(scene), pickle.loads(pickle.dumps(scene))):
            self.assertEqual((other.text, other.name), (scene.text, scene.name))
        del copy["proxy"]
        with self.assertRaisesRegex(tactus.FileError, "proxy"):
            copy.check()

    def test_bodies_are_as_the_loader_has_them(self):
        checked = tactus.Scene(SMALL).checked()
        self.assertEqual((checked.bodies, checked.proxy), (3, 0))
        box = checked.body(2)
        self.assertEqual((box["shape"], box["mass_kg"], box["half_extents_m"]), ("box", 1.0, [0.05, 0.05, 0.05]))
        self.assertAlmostEqual(box["inertia_kg_m2"][0], 1.0 * (0.1**2 + 0.1**2) / 12, 12)
        self.assertEqual(checked.corners(2).shape, (0, 3))
        with self.assertRaises(IndexError):
            checked.body(3)

    def test_numbers_keep_their_bits_and_text_its_characters(self):
        table = {"a": [0.1, 1e-300, -0.0, 5e22, 123456789.123456789], "b": 'quote " and \\ and\nline\tü€', "c": True,
                 "long": [float(i) / 7 for i in range(100)], "t": {"u": {"v": [{"w": 1}, {"w": [{"x": 2.5}]}]}},
                 "tables": [{"a": 1, "b": {"c": 2}}, {"a": 2}], "key with space": 1, "empty": [], "n": np.arange(3)}
        read = tomllib.loads(toml_text(table))
        self.assertEqual(read, {**table, "n": [0, 1, 2]})
        self.assertEqual(str(read["a"][2]), "-0.0")
        # The loader limits what a line may hold; a long path of the hand is not one line.
        self.assertLess(max(map(len, toml_text(table).splitlines())), 200)

    def test_mistakes_are_the_loaders_lines(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "wrong.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write('effects = ["gravity"]\n[proxy]\nshape = "sphere"\nradius_m = -1\nmas_kg = 0.2\n')
            program = subprocess.run([bench.PROGRAM, "run", path, "--virtual-time"], stderr=subprocess.PIPE, check=False)
            with self.assertRaises(tactus.FileError) as caught:
                tactus.Scene(path)
            self.assertEqual(program.stderr.decode(), f"tactus: {caught.exception}\n")
        for wrong, said in (({**SMALL, "proxi": {}}, "proxi"), ({**SMALL, "effects": "gravity"}, "effects"),
                            ({**SMALL, "title": object()}, "is no value of a scene"),
                            ({**SMALL, 3: 1}, "a key is text"),
                            ({**SMALL, "proxy": {**SMALL["proxy"], "mass_kg": float("nan")}}, "mass_kg")):
            with self.assertRaisesRegex(tactus.FileError, said):
                tactus.Session(wrong)
        with self.assertRaisesRegex(tactus.OptionError, "is no scene"):
            tactus.Scene(3)
        for arguments in ({"text": 3}, {"text": b"a = 1"}, {"text": "a = 1", "name": 3}):
            with self.assertRaisesRegex(tactus.OptionError, "accepted: text"):
                tactus.Scene(**arguments)
        for path, error in (("/tmp", tactus.FileError), ("/nowhere/x.toml", tactus.FileError), (None, tactus.OptionError),
                            ("a\0b", tactus.OptionError)):
            with self.subTest(path=path), self.assertRaisesRegex(error, "Scene.save: ") as caught:
                tactus.Scene(SMALL).save(path)
            self.assertNotIn("\n", str(caught.exception))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
