"""The sweep's folder: a file for each unit that is done, and the table of all."""
import csv
import io
import json
import os
import tempfile


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

    def path(self, unit):
        return os.path.join(self.folder, unit.name + '.json')

    def is_done(self, unit):
        return os.path.exists(self.path(unit))

    def write(self, unit, result):
        kept = {'unit': unit.name, 'varied': unit.varied, 'error': result['error'], 'figures': result['figures']}
        write_whole(self.path(unit), (json.dumps(kept, indent=1) + '\n').encode())

    def read(self, unit):
        with open(self.path(unit), encoding='utf-8') as file:
            return json.load(file)

    def forget(self, units):
        for unit in units:
            if self.is_done(unit):
                os.unlink(self.path(unit))


def table_of(plan, results):
    """CSV: a row for each unit that is done, in the plan's order; the same bytes, for any workers and any order."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator='\n')
    rows.writerow([*plan.columns, 'error'])
    for unit in plan.units:
        if not results.is_done(unit):
            continue
        result = results.read(unit)
        values = {**unit.varied, **result['figures']}
        rows.writerow([*(_cell(values.get(column)) for column in plan.columns), result['error']])
    return text.getvalue()


def _cell(value):
    if value is None:
        return ''
    if isinstance(value, bool):
        return 'true' if value else 'false'
    return repr(value) if isinstance(value, float) else str(value)
