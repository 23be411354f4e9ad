"""A sweep file as units: every value of every option and key with every other."""
import dataclasses
import hashlib
import itertools
import json
import os
import re
import tomllib

from .. import _core
from ..scene import Scene
from ..toml_text import toml_text

MAX_UNITS = 100_000
# Of `tactus run`, by the name that the library has for it.
OPTIONS = {'coupling': '--coupling', 'border': '--border', 'order': '--order', 'reach': '--reach',
           'accuracy': '--accuracy', 'world_precision': '--world-precision', 'rate_Hz': '--rate', 'ratio': '--ratio',
           'members': '--members', 'keep_gains': '--keep-gains', 'inject': '--inject', 'seed': '--seed'}
_NUMBER = re.compile('[1-9][0-9]{0,8}')
TABLES = ('scene', 'duration_s', 'seeds', 'options', 'keys', 'keep')


@dataclasses.dataclass(frozen=True)
class Unit:
    """One run: `name` is the hash of all that its result depends on."""
    name: str
    varied: dict       # what tells it from the others: option or key -> value
    scene_text: str
    arguments: list    # of `tactus run`, after the scene
    summary: list      # what is kept of the summary, as A/B

    @property
    def task(self):
        return 'run', self.scene_text, self.arguments, self.summary


@dataclasses.dataclass(frozen=True)
class Plan:
    units: list
    columns: list      # of the table: what is varied, then the figures


def read_plan(path, identity, scenes=''):
    """The units of a sweep file, for the program of this identity. Raises tactus.Error, a line for each mistake.

    scenes: the folder of the scenes that tactus has.
    """
    accepted = 'accepted: a sweep file, see tactus sweep --help'
    try:
        with open(path, 'rb') as file:
            table = tomllib.load(file)
        reader = _Reader(path, table, scenes)
        plan = reader.plan(identity)
    except OSError as error:
        raise _core.FileError(f'{path}: {error.strerror}; {accepted}') from None
    except ValueError as error:  # no TOML, or no UTF-8
        raise _core.FileError(f'{path}: {error}; {accepted}') from None
    except RecursionError:
        raise _core.FileError(f'{path}: lists or tables nested too deeply; {accepted}') from None
    if reader.mistakes:
        raise _core.FileError('\n'.join(f'{path}: {mistake}' for mistake in reader.mistakes))
    return plan


class _Reader:
    def __init__(self, path, table, scenes):
        self.path, self.table, self.scenes, self.mistakes = path, table, scenes, []

    def plan(self, identity):
        for key in self.table:
            if key not in TABLES:
                self._mistake(key, 'no such key', ', '.join(TABLES))
        scene = self._scene()
        duration = self.table.get('duration_s', 10.0)
        if not _is_number(duration) or not 0.001 <= duration <= 1e6:
            self._mistake('duration_s', duration, '0.001 to 1e6 s')
        options = self._values('options', OPTIONS)
        options |= self._seeds()
        keys = self._values('keys', None)
        summary, figures = self._keep()
        if self.mistakes:
            return None
        count = 1
        for values in (*options.values(), *keys.values()):
            count *= len(values)
        if count > MAX_UNITS:
            self._mistake('', f'{count} units', f'at most {MAX_UNITS}')
            return None
        tail = ['--duration', repr(float(duration)), *(['--figures', ','.join(figures)] if figures else [])]
        units = self._units(scene, options, keys, tail, summary, identity)
        return Plan(units, [*options, *keys, *summary, *figures])

    def _units(self, scene, options, keys, tail, summary, identity):
        units, names = [], [*options, *keys]
        texts = {}  # the scene's text, by the values of its keys
        for values in itertools.product(*options.values(), *keys.values()):
            varied = dict(zip(names, values))
            changed = values[len(options):]
            if changed not in texts:
                texts[changed] = self._text(scene, dict(zip(keys, changed)))
            if texts[changed] is None:
                return []
            arguments = [word for name in options for word in _argument(name, varied[name])] + tail
            content = json.dumps([texts[changed], arguments, summary, identity])
            name = hashlib.sha256(content.encode()).hexdigest()[:32]
            units.append(Unit(name, varied, texts[changed], arguments, summary))
        return units

    def _mistake(self, where, found, accepted):
        line = ' '.join(f'{where}: {found!s:.80}'.splitlines())
        self.mistakes.append(f'{line}; accepted: {accepted}')

    def _scene(self):
        name = self.table.get('scene')
        if not isinstance(name, str):
            self._mistake('scene', name, 'the path of a scene, from the folder of this file, or a scene of tactus')
            return None
        path = os.path.join(os.path.dirname(self.path), name)
        if self.scenes and not os.path.exists(path):
            known = os.path.join(self.scenes, os.path.basename(name))
            path = known if name == os.path.basename(name) and os.path.exists(known) else path
        try:
            return Scene(path)
        except _core.Error as error:
            self.mistakes += [f'scene: {line}' for line in str(error).splitlines()]
            return None

    def _values(self, table, known):
        given = self.table.get(table, {})
        if not isinstance(given, dict):
            self._mistake(table, given, f'a table [{table}]')
            return {}
        values = {}
        for name, value in given.items():
            if known is not None and name not in known:
                self._mistake(f'[{table}] {name}', 'no such option', ', '.join(known))
                continue
            values[name] = self._list(f'[{table}] {name}', value)
        return values

    def _list(self, where, value):
        if isinstance(value, dict):
            low, high, steps = (value.get(key) for key in ('from', 'to', 'steps'))
            if set(value) != {'from', 'to', 'steps'} or not _is_number(low) or not _is_number(high) or \
                    not isinstance(steps, int) or not 2 <= steps <= MAX_UNITS:
                self._mistake(where, value, f'{{from = A, to = B, steps = N}}, two numbers, and 2 to {MAX_UNITS} steps')
                return []
            return self._each_once(where, [low + (high - low) * i / (steps - 1) for i in range(steps)])
        values = value if isinstance(value, list) else [value]
        if not values or not all(map(_is_value, values)):
            self._mistake(where, value, 'a value, a list of them, or {from, to, steps}')
            return []
        return self._each_once(where, [_as_tuple(item) for item in values])

    def _each_once(self, where, values):
        """Two equal values are the same unit twice."""
        known = set()
        for value in values:
            text = repr(value)
            if text in known:
                self._mistake(where, f'{text} twice', 'each value once')
                return []
            known.add(text)
        return values

    def _seeds(self):
        seeds = self.table.get('seeds')
        if seeds is None:
            return {}
        if isinstance(seeds, int) and not isinstance(seeds, bool) and 1 <= seeds <= MAX_UNITS:
            return {'seed': list(range(1, seeds + 1))}
        if isinstance(seeds, list) and seeds and all(type(seed) is int and seed >= 0 for seed in seeds):
            return {'seed': self._each_once('seeds', seeds)}
        self._mistake('seeds', seeds, f'their number, 1 to {MAX_UNITS}, or a list of them')
        return {}

    def _keep(self):
        keep = self.table.get('keep', {})
        lists = []
        for name in ('summary', 'columns'):
            words = keep.get(name, []) if isinstance(keep, dict) else None
            if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
                self._mistake(f'[keep] {name}', words, 'a list of texts')
                words = []
            lists.append(words)
        if isinstance(keep, dict):
            for name in keep:
                if name not in ('summary', 'columns'):
                    self._mistake(f'[keep] {name}', 'no such key', 'summary, columns')
        if not any(lists) and not self.mistakes:
            self._mistake('[keep]', 'nothing is kept', 'summary = ["hand/force_max_N"], columns = ["force_z_N:rms"]')
        return lists

    def _text(self, scene, keys):
        changed = Scene(scene)
        for name, value in keys.items():
            try:
                _set(changed, name.split('.'), _as_list(value))
            except (KeyError, IndexError, TypeError):
                self._mistake(f'[keys] {name}', 'the scene has no such table',
                              'TABLE.KEY, and for a list TABLE.N.KEY, N from 1: body.2.mass_kg')
                return None
        try:
            changed.check()
        except _core.Error as error:
            where = ', '.join(f'{name} = {value}' for name, value in keys.items())
            self.mistakes += [f'{where}: {line}' for line in str(error).splitlines()]
            return None
        return toml_text(changed)


def _set(table, path, value):
    """The last key may be new: it has a default. Tables must be there."""
    for key in path[:-1]:
        table = table[_index(key)] if isinstance(table, list) else table[key]
    table[_index(path[-1]) if isinstance(table, list) else path[-1]] = value


def _index(number):
    """Of an item of a list by its number from 1."""
    if not _NUMBER.fullmatch(number):
        raise IndexError(number)
    return int(number) - 1


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300


def _is_value(value):
    return all(map(_is_value, value)) if isinstance(value, list) else isinstance(value, (bool, int, float, str))


def _as_tuple(value):
    return tuple(map(_as_tuple, value)) if isinstance(value, list) else value


def _as_list(value):
    return list(map(_as_list, value)) if isinstance(value, tuple) else value


def _argument(name, value):
    if value is True or value is False:
        return [OPTIONS[name]] if value else []
    return [OPTIONS[name], repr(value) if isinstance(value, float) else str(value)]
