#!/usr/bin/python3
"""tests/tools/export/read_back.py PROGRAM hdf5|mcap|trace FOLDER: exports a run and reads it as other programs do.

The numbers are compared with those of the CSV, bit by bit; that the CSV's are the tape's is export_test.cpp's. FOLDER gets the
packages of node that `mcap` needs. Exit 77 where the reader is missing.
"""
import csv
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

PROGRAM, WHAT, NODE = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
SCENE = os.path.join(HERE, "..", "..", "..", "sim", "scenes", "card_house.toml")
TICKS, FRAMES = 5000, 250


def bits(number):
    return struct.pack("<d", float(number))


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class ReadBack(unittest.TestCase):
    @classmethod
    def at(cls, name):
        return os.path.join(cls.scratch.name, name)

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        subprocess.run([PROGRAM, "run", SCENE, "--virtual-time", "--duration", "5", "--record", cls.at("a.tape")],
                       check=True, stdout=subprocess.DEVNULL)
        out = subprocess.run([PROGRAM, "export", cls.at("a.tape"), "--csv", cls.at("a.csv"), "--hdf5", cls.at("a.h5"),
                              "--mcap", cls.at("a.mcap"), "--perfetto", cls.at("a.json"), "--world", "50", "--json"],
                             check=True, stdout=subprocess.PIPE).stdout
        cls.report = json.loads(out)
        cls.ticks, cls.bodies = rows_of(cls.at("a.csv")), rows_of(cls.at("a.bodies.csv"))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_the_report_counts_what_is_there(self):
        self.assertEqual(self.report["rows"], TICKS)
        self.assertEqual(len(self.ticks), TICKS)
        self.assertEqual(len(self.ticks[0]), self.report["columns"])
        self.assertEqual(len(self.bodies), self.report["bodies"])
        self.assertEqual(self.report["bytes"], sum(os.path.getsize(path) for path in self.report["files"]))
        self.assertEqual(self.report["warning"], "")


class Hdf5(ReadBack):
    def test_every_column_has_the_numbers_and_says_what_it_is(self):
        import h5py
        with h5py.File(self.at("a.h5"), "r") as file:
            self.assertEqual(set(file["ticks"]), set(self.ticks[0]))
            for name, column in file["ticks"].items():
                given = [row[name] for row in self.ticks]
                if column.dtype.kind == "f":
                    self.assertEqual([bits(x) for x in column], [bits(x) for x in given], name)
                else:
                    self.assertEqual(column.dtype.kind, "u")
                    self.assertEqual([int(x) for x in column], [int(x) for x in given], name)
                self.assertTrue(column.attrs["meaning"])
                self.assertIn("frame", column.attrs)
                self.assertIn("unit", column.attrs)
            self.assertEqual(file["ticks/force_x_N"].attrs["unit"], "N")
            self.assertEqual(file["ticks/force_x_N"].attrs["frame"], "device")

    def test_the_bodies_are_one_array_of_poses(self):
        import h5py
        with h5py.File(self.at("a.h5"), "r") as file:
            bodies = file["bodies"]
            self.assertEqual(bodies["pose"].shape, (len(self.bodies), 7))
            names = ["position_x_m", "position_y_m", "position_z_m", "rotation_w", "rotation_x", "rotation_y", "rotation_z"]
            roles = ["proxy", "member", "border"]
            poses, ids, role, ticks = (bodies[name][:] for name in ("pose", "body", "role", "tick"))
            for i, row in enumerate(self.bodies):
                self.assertEqual([bits(x) for x in poses[i]], [bits(row[name]) for name in names])
                self.assertEqual((ids[i], roles[role[i]], ticks[i]), (int(row["body"]), row["role"], int(row["tick"])))

    def test_the_scene_and_the_settings_are_there(self):
        import h5py
        with h5py.File(self.at("a.h5"), "r") as file:
            self.assertIn("card_house", file["scene"][()].decode())
            self.assertEqual(json.loads(file["settings"][()])["coupling"], "sub-world")
            self.assertEqual(file.attrs["scene_name"], "card_house")
            self.assertEqual(file.attrs["period_s"], 1e-3)
            self.assertTrue(file.attrs["program"].startswith("tactus "))


class Mcap(ReadBack):
    def read(self):
        script = os.path.join(NODE, "read_mcap.js")
        out = subprocess.run(["node", script, self.at("a.mcap")], check=True, stdout=subprocess.PIPE).stdout
        read = json.loads(out)
        for messages in read["messages"].values():
            for message in messages:
                message["data"] = json.loads(message["text"])
        return read

    def test_the_messages_have_the_numbers_and_fit_their_schemas(self):
        import jsonschema
        read = self.read()
        ticks, bodies = read["messages"]["tactus/tick"], read["messages"]["tactus/bodies"]
        self.assertEqual(len(ticks), TICKS)
        self.assertEqual(len(bodies), FRAMES + 1)  # the fixed bodies once
        for message, row in zip(ticks, self.ticks):
            self.assertEqual(set(message["data"]), set(row))
            self.assertEqual([bits(message["data"][name]) for name in row], [bits(x) for x in row.values()])
            self.assertEqual(message["time_ns"], round(1e9 * float(row["time_s"])))
        for topic, name in (("tactus/tick", "tactus.Tick"), ("tactus/bodies", "foxglove.SceneUpdate")):
            self.assertEqual(read["schemas"][name]["encoding"], "jsonschema")
            schema = json.loads(read["schemas"][name]["text"])
            jsonschema.Draft7Validator.check_schema(schema)
            validator = jsonschema.Draft7Validator(schema)
            for message in read["messages"][topic][:50]:
                validator.validate(message["data"])
        self.assertTrue(read["library"].startswith("tactus "))

    def test_the_bodies_are_where_the_csv_has_them(self):
        frames = [m["data"]["entities"][0] for m in self.read()["messages"]["tactus/bodies"]]
        self.assertEqual([frame["id"] for frame in frames[:2]], ["fixed", "sub-world"])
        cards = [row for row in self.bodies if row["tick"] == self.bodies[0]["tick"] and row["body"] != "0"]
        places = {tuple(bits(row[f"position_{k}_m"]) for k in "xyz") for row in cards}
        drawn = {tuple(bits(box["pose"]["position"][k]) for k in "xyz") for box in frames[1]["cubes"]}
        self.assertTrue(places)
        self.assertEqual(places & drawn, places)

    def test_the_index_finds_every_message_in_order_and_half_of_them_from_the_middle_on(self):
        read = self.read()
        self.assertEqual(read["indexed"], read["counted"])
        self.assertEqual(read["counted"], TICKS + FRAMES + 1)
        self.assertEqual(read["disordered"], 0)
        self.assertGreater(read["chunks"], 1)
        self.assertAlmostEqual(read["from_half"] / read["counted"], 0.5, delta=0.01)


class Trace(ReadBack):
    def test_counters_and_cycles(self):
        with open(self.at("a.json"), encoding="utf-8") as file:
            events = json.load(file)["traceEvents"]
        forces = [event for event in events if event["ph"] == "C" and event["name"] == "force"]
        self.assertEqual(len(forces), TICKS)
        for event, row in zip(forces, self.ticks):
            self.assertEqual({name: bits(x) for name, x in event["args"].items()},
                             {name: bits(row[name]) for name in ("force_x_N", "force_y_N", "force_z_N")})
            self.assertAlmostEqual(event["ts"], 1e3 * int(row["tick"]))
        cycles = [event for event in events if event["ph"] == "X"]
        self.assertEqual(len(cycles), sum(row["adopts"] == "1" for row in self.ticks))
        self.assertAlmostEqual(sum(cycle["dur"] for cycle in cycles), 1e3 * TICKS)


def missing_hdf5():
    try:
        import h5py  # noqa: F401
    except ImportError:
        return "no h5py (Debian: python3-h5py)"
    return None


def missing_mcap():
    try:
        import jsonschema  # noqa: F401
    except ImportError:
        return "no jsonschema (Debian: python3-jsonschema)"
    for program in ("node", "npm"):
        if shutil.which(program) is None:
            return f"no {program}"
    os.makedirs(NODE, exist_ok=True)
    for name in ("package.json", "package-lock.json", "read_mcap.js"):
        shutil.copy(os.path.join(HERE, "node", name), NODE)
    install = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=NODE, capture_output=True)
    return None if install.returncode == 0 else "npm cannot install @mcap/core"


def main():
    why = {"hdf5": missing_hdf5, "mcap": missing_mcap, "trace": lambda: None}[WHAT]()
    if why is not None:
        print(f"tactus-skipped: {why}")
        return 77
    case = {"hdf5": Hdf5, "mcap": Mcap, "trace": Trace}[WHAT]
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(case)
    return 0 if unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
