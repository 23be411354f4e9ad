"""Plain values as TOML that reads as the same bits."""
import collections.abc
import re

from . import _core

_ITEMS_IN_LINE = 8  # the loader limits what a line may hold
_BARE = re.compile(r'[A-Za-z0-9_-]+')
_ESCAPES = {'"': '\\"', '\\': '\\\\', '\b': '\\b', '\t': '\\t', '\n': '\\n', '\f': '\\f', '\r': '\\r'}


def toml_text(table):
    """The mapping as a TOML document."""
    lines = []
    try:
        _add_table(lines, table, ())
    except RecursionError:
        raise too_deep() from None
    return '\n'.join(lines) + '\n'


def too_deep():
    return _core.FileError('Scene: mappings or lists nested too deeply, or within themselves; accepted: the tables of '
                           '`tactus scene keys`')


def _quoted(text):
    return '"' + ''.join(_ESCAPES.get(c) or (f'\\u{ord(c):04x}' if ord(c) < 32 or ord(c) == 127 else c)
                         for c in text) + '"'


def _key(key):
    if not isinstance(key, str):
        raise _core.FileError(f'{key!r:.64}: a key is text; accepted: the keys of `tactus scene keys`')
    return key if _BARE.fullmatch(key) else _quoted(key)


def _is_tables(value):
    return (isinstance(value, (list, tuple)) and len(value) > 0 and
            all(isinstance(item, collections.abc.Mapping) for item in value))


def _add_table(lines, table, path):
    """Values first, then tables: what follows a header belongs to it."""
    tables = []
    for key, value in table.items():
        if isinstance(value, collections.abc.Mapping) or (_is_tables(value) and not path):
            tables.append((key, value))
        else:
            lines.append(f'{_key(key)} = {_value(value, (*path, str(key)))}')
    for key, value in tables:
        here = (*path, _key(key))
        name = '.'.join(here)
        for header, item in [(f'[{name}]', value)] if isinstance(value, collections.abc.Mapping) else \
                [(f'[[{name}]]', item) for item in value]:
            lines.append(header)
            _add_table(lines, item, here)


def _value(value, path):
    if hasattr(value, 'tolist'):  # NumPy's numbers and arrays
        value = value.tolist()
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)  # the shortest that reads as the same bits; nan and inf as TOML has them
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, (list, tuple)):
        between = ',\n  ' if len(value) > _ITEMS_IN_LINE else ', '
        return '[' + between.join(_value(item, path) for item in value) + ']'
    if isinstance(value, collections.abc.Mapping):
        return '{' + ', '.join(f'{_key(k)} = {_value(v, (*path, str(k)))}' for k, v in value.items()) + '}'
    raise _core.FileError(f'{".".join(path)}: {value!r:.64} is no value of a scene; accepted: numbers, text, True, '
                           'False, lists, mappings')
