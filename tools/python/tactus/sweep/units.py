"""Runs a unit in a process of its own. Nothing but the standard library: workers on other machines run it too."""
import json
import os
import subprocess
import tempfile


def identity_of(program):
    """Version and instruction set of a program, as its results depend on them."""
    try:
        lines = subprocess.run([program, '--version'], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                               check=False).stdout.decode(errors='replace').splitlines()
    except OSError as error:
        return f'no tactus: {error}'
    built_for = lines[1].split(',')[0].removeprefix('built for').strip() if len(lines) > 1 else '?'
    return f'{lines[0] if lines else "?"}, {built_for}'


def run_task(program, task, started=lambda process: None):
    """The result of a run or of an experiment's part, in a process of its own; no time is in it.

    task: ('run', scene_text, arguments, summary) or ('part', arguments).
    started: is given the process. A Ctrl-C of the terminal does not reach it: half of a run is no result.
    """
    kind, *rest = task
    with tempfile.TemporaryDirectory(prefix='tactus-sweep-') as folder:
        return (_run if kind == 'run' else _part)(program, folder, started, *rest)


def _process(command, folder, started):
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=folder,
                          start_new_session=True) as process:
        started(process)
        out, said = process.communicate()
    return process.returncode, out, said


def _killed(status):
    return {'killed': -status, 'error': f'ended by signal {-status}', 'figures': {}}


def _last_line(said, status):
    lines = said.decode(errors='replace').strip().splitlines()
    return (lines or [f'exit status {status}'])[-1]


def _part(program, folder, started, arguments):
    """'bytes', as the program prints them, or 'error'."""
    status, out, said = _process([program, *arguments], folder, started)
    if status < 0:
        return _killed(status)
    return {'error': '', 'bytes': out} if status == 0 else {'error': _last_line(said, status).removeprefix('tactus: ')}


def _run(program, folder, started, scene_text, arguments, summary):
    """'figures' by name, or 'error' in one line; 'killed' if a signal ended it."""
    scene = os.path.join(folder, 'scene.toml')
    with open(scene, 'w', encoding='utf-8') as file:
        file.write(scene_text)
    status, out, said = _process([program, 'run', scene, '--virtual-time', *arguments, '--json'], folder, started)
    if status < 0:
        return _killed(status)
    try:
        report = json.loads(out)
    except ValueError:
        return {'error': _last_line(said, status), 'figures': {}}
    if 'error' in report:
        return {'error': report['error'].replace(folder + os.sep, '').replace('\n', '; '), 'figures': {}}
    figures, missing = {}, []
    for path in summary:
        value = report
        for key in path.split('/'):
            value = value.get(key) if isinstance(value, dict) else None
        if value is None or isinstance(value, (dict, list)):
            missing.append(path)
        figures[path] = value
    figures |= report.get('figures', {})
    error = f'the summary has no figure {missing[0]}' if missing else ''
    return {'error': error, 'figures': figures if not error else {}}
