#!/usr/bin/python3
"""tests/tools/python/stubs_test.py PROGRAM FOLDER: the stubs (.pyi) have the names, parameters and defaults of the module, and it
theirs. What a type checker would say of the annotations themselves is not asked: Debian's mypy is no part of the setup."""
import ast
import inspect
import os
import re
import sys
import typing
import unittest

import bench
import gymnasium_here  # noqa: F401
import tactus
import tactus.gym

ADDED_BY_GYMNASIUM = {"render", "unwrapped", "np_random", "np_random_seed", "metadata", "render_mode", "spec", "action_space",
                      "observation_space", "has_wrapper_attr", "get_wrapper_attr", "set_wrapper_attr"}


def stub_of(name):
    with open(os.path.join(bench.MODULE, "tactus", name), encoding="utf-8") as file:
        return ast.parse(file.read())


def parameters_of_stub(function):
    """[(name, kind, default)] of a function in a stub, without self; a default is its value, or inspect.Parameter.empty."""
    kinds, empty, given = inspect.Parameter, inspect.Parameter.empty, function.args
    value = lambda node: empty if node is None else ast.literal_eval(node)  # noqa: E731
    plain = given.posonlyargs + given.args
    defaults = [None] * (len(plain) - len(given.defaults)) + given.defaults
    found = [(arg.arg, kinds.POSITIONAL_OR_KEYWORD, value(default)) for arg, default in zip(plain, defaults)]
    if given.vararg:
        found.append((given.vararg.arg, kinds.VAR_POSITIONAL, empty))
    found += [(arg.arg, kinds.KEYWORD_ONLY, value(default)) for arg, default in zip(given.kwonlyargs, given.kw_defaults)]
    if given.kwarg:
        found.append((given.kwarg.arg, kinds.VAR_KEYWORD, empty))
    return found[1:]


def parameters_of(function):
    """The same of a function of the module; of one in C++ by its docstring's first line."""
    if inspect.isroutine(function) and (line := re.match(r"\w+\((.*)\) -> ", function.__doc__ or "")):
        names = [part.split(":")[0].strip() for part in line[1].split(", ") if ":" in part]
        return [(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.empty) for name in names][1:]
    return [(p.name, p.kind, p.default) for p in inspect.signature(function).parameters.values()][1:]


class Stubs(unittest.TestCase):
    def check_class(self, stub, real, inherited):
        in_stub = {}
        for item in stub.body:
            if isinstance(item, ast.FunctionDef):
                in_stub[item.name] = item
            elif isinstance(item, ast.AnnAssign):
                in_stub[item.target.id] = None
        for name, item in in_stub.items():
            with self.subTest(name=f"{real.__name__}.{name}"):
                self.check_member(real, name, item)
        public = {name for name in dir(real) if not name.startswith("_")} - inherited
        self.assertEqual(public - set(in_stub), set(), f"{real.__name__}: not in the stub")

    def check_member(self, real, name, item):
        if item is None:  # x: type, of the object
            found = inspect.getattr_static(real, name, None)
            self.assertTrue(inspect.isdatadescriptor(found) or f"self.{name} = " in inspect.getsource(real), "no such attribute")
            return
        self.assertTrue(hasattr(real, name), "no such member")
        found = inspect.getattr_static(real, name)
        if any(isinstance(mark, ast.Name) and mark.id == "property" for mark in item.decorator_list):
            self.assertTrue(inspect.isdatadescriptor(found))
            return
        self.assertTrue(callable(found), "no function")
        wanted, there = parameters_of_stub(item), parameters_of(found)
        if name.startswith("__") and name != "__init__":  # called by place
            self.assertTrue(len(there) == len(wanted) or any(kind == inspect.Parameter.VAR_POSITIONAL for _, kind, _ in there))
        else:
            self.assertEqual(there, wanted)

    def check_module(self, stub, module, inherited=frozenset()):
        names = set()
        for item in stub.body:
            if isinstance(item, ast.ClassDef):
                names.add(item.name)
                with self.subTest(name=item.name):
                    self.assertTrue(hasattr(module, item.name), "no such class")
                    self.check_class(item, getattr(module, item.name), inherited)
            elif isinstance(item, ast.AnnAssign):
                names.add(item.target.id)
                self.assertEqual(type(getattr(module, item.target.id)).__name__, item.annotation.id)
        return names

    def test_the_module(self):
        mapping = {name for name in dir(typing.MutableMapping) if not name.startswith("_")} | {"keys", "values", "items", "get",
                   "pop", "popitem", "clear", "update", "setdefault"}
        exceptions = {name for name in dir(OSError) if not name.startswith("_")}
        names = self.check_module(stub_of("__init__.pyi"), tactus, mapping | exceptions | {"load", "parse"})
        self.assertEqual(names, set(tactus.__all__))

    def test_gym(self):
        self.assertEqual(self.check_module(stub_of("gym.pyi"), tactus.gym, ADDED_BY_GYMNASIUM), {"TouchEnv"})

    def test_a_difference_is_seen(self):
        """The comparison itself: a stub that lags behind fails it."""
        class Real:
            def step(self, ticks, *, pace=1.0):
                pass

        for text, same in (("def step(self, ticks: int, *, pace: float = 1.0) -> None: ...", True),
                           ("def step(self, ticks: int, *, pace: float = 2.0) -> None: ...", False),
                           ("def step(self, ticks: int, pace: float = 1.0) -> None: ...", False),
                           ("def step(self, tick: int, *, pace: float = 1.0) -> None: ...", False)):
            function = ast.parse(text).body[0]
            self.assertEqual(parameters_of_stub(function) == parameters_of(Real.step), same, text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
