"""Scenes as mappings with the keys of their TOML."""
import collections.abc
import copy
import os
import tomllib

from . import _core
from .toml_text import too_deep, toml_text


class Scene(collections.abc.MutableMapping):
    """A scene: a mapping with the keys of the TOML (`tactus scene keys`), nested as there.

    Scene('wall.toml') reads a file, Scene({...}) takes the keys, Scene(text='...') a text. Nothing is checked before
    the scene is used: check(), save() and Session raise a FileError with the loader's own lines.
    """

    def __init__(self, source=None, *, text=None, name='scene'):
        if not isinstance(name, str):
            raise _core.OptionError(f'Scene: name: {name!r:.64}; accepted: text')
        self._name = name
        self._checked = self._checked_text = None
        if text is not None:
            if source is not None:
                raise _core.OptionError('Scene: both a source and a text; accepted: one of them')
            self._keys = tomllib.loads(self._check_text(text))
        elif isinstance(source, Scene):
            self._keys, self._name = copy.deepcopy(source._keys), source._name
        elif isinstance(source, collections.abc.Mapping):
            try:
                self._keys = copy.deepcopy(dict(source))
            except RecursionError:
                raise too_deep() from None
        elif isinstance(source, (str, os.PathLike)):
            checked = _core.CheckedScene.load(source)
            self._name = checked.name
            self._keys = tomllib.loads(checked.text)
            self._checked, self._checked_text = checked, self.text
        elif source is None:
            self._keys = {}
        else:
            raise _core.OptionError(f'Scene: {source!r:.64} is no scene; accepted: a path, a mapping, or text=')

    def _check_text(self, text):
        if not isinstance(text, str):
            raise _core.OptionError(f'Scene: text: {text!r:.64}; accepted: text')
        return _parsed(text, self._name).text

    def __getstate__(self):  # of a copy; what the loader made of it is made again
        return {**self.__dict__, '_checked': None, '_checked_text': None}

    def __getitem__(self, key):
        return self._keys[key]

    def __setitem__(self, key, value):
        self._keys[key] = value

    def __delitem__(self, key):
        del self._keys[key]

    def __iter__(self):
        return iter(self._keys)

    def __len__(self):
        return len(self._keys)

    def __repr__(self):
        return f'<tactus.Scene {self._name!r}: {", ".join(self._keys)}>'

    @property
    def text(self):
        """The scene as TOML: what save() writes, and what lines in messages count in."""
        return toml_text(self._keys)

    @property
    def name(self):
        """The file's name without folder and extension, or the one that was given."""
        return self._name

    def check(self):
        """Raises FileError if the scene has mistakes; returns the loader's warnings, a line each."""
        return self.checked().warnings

    def save(self, path):
        """Writes a TOML that loads to the same bits, with the data of the files that the scene names. Raises FileError."""
        text = self.checked().text
        try:
            with open(path, 'w', encoding='utf-8') as file:
                file.write(text)
        except OSError as error:
            raise _core.FileError(f'Scene.save: {path}: {error.strerror}; accepted: a file in a folder that exists') \
                from None
        except (TypeError, ValueError):
            raise _core.OptionError(f'Scene.save: {path!r:.64} is no path; accepted: text or a path, without NUL') from None

    def checked(self):
        """The scene as the loader has it: bodies (a count), body(i), parts(i), corners(i),
        triangles(i), proxy, title, warnings."""
        text = self.text
        if self._checked is None or text != self._checked_text:
            self._checked, self._checked_text = _parsed(text, self._name), text
        return self._checked


def _parsed(text, name):
    try:
        text.encode(), name.encode()
    except UnicodeEncodeError as error:
        raise _core.FileError(f'Scene: {error.object[error.start]!r} is no character; accepted: text without lone '
                              'surrogates') from None
    return _core.CheckedScene.parse(text, name)


def checked(scene):
    """The checked scene of a Scene, a mapping or a path."""
    if scene is None:
        raise _core.OptionError('Session: None is no scene; accepted: a path, a mapping, or a Scene')
    return (scene if isinstance(scene, Scene) else Scene(scene)).checked()
