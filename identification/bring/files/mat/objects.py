"""Objects that only MATLAB knows, and the line that makes a structure of each.

Tables, timetables, durations and datetimes are read, see `tables`. A timeseries, a Dataset and
texts as objects are other classes of MATLAB's, and a later MATLAB may keep a table in another
way: a reader that guesses at those would be wrong one day without a word.
"""

_NUMBERS = (
    " for f = fieldnames(log).', v = log.(f{{1}}); "
    "if isdatetime(v), log.(f{{1}}) = posixtime(v); "
    "elseif isduration(v), log.(f{{1}}) = seconds(v); "
    "elseif ~isnumeric(v) && ~islogical(v), log = rmfield(log, f{{1}}); end, end"
)
"""What leaves of a structure's fields numbers alone: times in s, no texts."""
LINES = {
    "table": 'log = table2struct({name}, "ToScalar", true);' + _NUMBERS,
    "timetable": ('log = table2struct(timetable2table({name}), "ToScalar", true);' + _NUMBERS),
    "timeseries": 'log = struct("time", {name}.Time, "data", {name}.Data);',
    "Dataset": (
        "log = struct(); for k = 1:{name}.numElements, e = {name}{{k}}; "
        'log.(matlab.lang.makeValidName(e.Name)) = struct("time", e.Values.Time, '
        '"data", e.Values.Data); end'
    ),
    "datetime": "log = posixtime({name});",
    "duration": "log = seconds({name});",
    "string": "log = char({name});",
    "categorical": "log = double({name});",
}
"""What makes a structure, or an array, of an object, by the last part of its class."""


def way_out(name: str, kind: str) -> str:
    """Why an object can't be read, and what to do.

    Args:
        name: Its path in the file.
        kind: Its class.

    Returns:
        The class, and the line to run in MATLAB.
    """
    line = LINES.get(kind.rpartition(".")[2], "log = struct({name});").format(name=name)
    return (
        f"an object of MATLAB's class {kind or 'unknown'}|In MATLAB: {line} "
        'save("log.mat", "log", "-v7")'
    )
