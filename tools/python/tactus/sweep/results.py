"""The sweep's folder: a file for each unit that is done, and the table of all."""
import csv
import errno
import io
import json
import math
import os
import tempfile

from .. import _core


def write_whole(path, content):
    """Whole or not at all: under another name first. content: bytes."""
    folder = os.path.dirname(path)
    os.makedirs(folder, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=folder, prefix='.', suffix='.part', delete=False) as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(file.name, path)


class Results:
    def __init__(self, folder):
        self.folder = folder

    def prepare(self):
        """The folder is there, and takes files."""
        try:
            os.makedirs(self.folder, exist_ok=True)
            if not os.access(self.folder, os.W_OK | os.X_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        except OSError as error:
            raise _core.OptionError(f'--folder {self.folder}: {error.strerror}; accepted: a folder to write the results '
                                    'into') from None

    def path(self, unit):
        return os.path.join(self.folder, unit.name + '.json')

    def is_done(self, unit):
        return os.path.exists(self.path(unit))

    def write(self, unit, result):
        kept = {'unit': unit.name, 'varied': unit.varied, 'error': result['error'], 'figures': result['figures']}
        try:
            write_whole(self.path(unit), (json.dumps(kept, indent=1) + '\n').encode())
        except OSError as error:
            raise _core.MachineError(f'{self.path(unit)}: {error.strerror}; the same command goes on') from None

    def read(self, unit):
        path = self.path(unit)
        try:
            with open(path, encoding='utf-8') as file:
                result = json.load(file)
        except OSError as error:
            raise _core.FileError(f'{path}: {error.strerror}; accepted: a result that can be read') from None
        except (ValueError, RecursionError):  # no JSON, or no UTF-8
            result = None
        if not isinstance(result, dict) or result.get('unit') != unit.name or not isinstance(result.get('error'), str) \
                or not isinstance(result.get('figures'), dict):
            raise _core.FileError(f'{path}: is damaged; accepted: results as tactus sweep wrote them; delete it, and the '
                                  'unit runs again')
        return result

    def forget(self, units):
        for unit in units:
            if self.is_done(unit):
                os.unlink(self.path(unit))


def table_of(plan, results):
    """CSV: a row for each unit that is done, in the plan's order; the same bytes, for any workers and any order."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator='\n')
    rows.writerow([*plan.columns, 'error'])
    for values in _rows(plan, results):
        rows.writerow([_cell(values.get(column)) for column in (*plan.columns, 'error')])
    return text.getvalue()


def hdf5_of(plan, results):
    """The same table as an HDF5 file's bytes: the dataset /units, a record for each row with a field for each column.

    A column of numbers is float64, NaN where a row has none; one of integers alone is int64; all others are text as in
    the CSV.
    """
    try:
        import h5py
        import numpy
    except ImportError as error:
        raise _core.MachineError(f'--hdf5: {error} (Debian: python3-h5py)') from None
    rows = list(_rows(plan, results))
    columns = {name: [values.get(name) for values in rows] for name in (*plan.columns, 'error')}
    types = [(name, _type_of(values, h5py)) for name, values in columns.items()]
    table = numpy.zeros(len(rows), types)
    for name, kind in types:
        if kind == 'f8':
            table[name] = [math.nan if value is None else value for value in columns[name]]
        else:
            table[name] = columns[name] if kind == 'i8' else [_cell(value).encode() for value in columns[name]]
    content = io.BytesIO()
    with h5py.File(content, 'w') as file:
        file.create_dataset('units', data=table)
        file.attrs['version'] = _core.__version__
    return content.getvalue()


def _type_of(values, h5py):
    """A field's type. Text is of fixed length: what is of variable length has addresses of its own in a file."""
    if values and all(type(value) is int and abs(value) < 2**63 for value in values):
        return 'i8'
    if values and all(value is None or type(value) in (int, float) for value in values):
        return 'f8'
    return h5py.string_dtype('utf-8', max([1, *(len(_cell(value).encode()) for value in values)]))


def _rows(plan, results):
    """Values by column, of each unit that is done."""
    for unit in plan.units:
        if results.is_done(unit):
            result = results.read(unit)
            yield {**unit.varied, **result['figures'], 'error': result['error']}


def _cell(value):
    if value is None:
        return ''
    if isinstance(value, bool):
        return 'true' if value else 'false'
    return repr(value) if isinstance(value, float) else str(value)
