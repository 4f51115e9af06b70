"""Comparison of demosaicing methods: results against the truth."""

from camsim.measure.demosaic.competition import Ranking, compete, ranked
from camsim.measure.demosaic.methods import Method, methods
from camsim.measure.demosaic.program import run_program
from camsim.measure.demosaic.scaling import Fault
from camsim.measure.demosaic.subject import Subject, subject_of_capture, subject_of_picture
from camsim.measure.demosaic.verdict import Verdict, evaluate

__all__ = [
    "Fault",
    "Method",
    "Ranking",
    "Subject",
    "Verdict",
    "compete",
    "evaluate",
    "methods",
    "ranked",
    "run_program",
    "subject_of_capture",
    "subject_of_picture",
]
