"""The files that type checkers judge are no tests: the wrong one cannot even be imported."""

collect_ignore = ["right.py", "wrong.py"]
