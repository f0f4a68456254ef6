"""A method's name tells which pipeline runs, and by which lens it corrects."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import get_args

import cv2
import pytest

from agent.drivers.bus_camera import captured
from agent.full_method import FullMethod
from agent.geometry import calibrated_projection, hemispherical_projection
from agent.methods import make_pipeline
from agent.paper_method import PaperMethod
from agent.pipeline import Method, Pipeline, Step
from tests.bench.frames import EXCERPT, Subject, open_case

FRAMES = 3


class Untimed:
    def stage(self, _: str) -> AbstractContextManager[None]:
        return nullcontext()


@pytest.fixture(scope="module")
def subject() -> Subject:
    cv2.setNumThreads(1)
    return open_case(EXCERPT).subjects[0]


def named(method: Method, subject: Subject) -> Pipeline:
    return make_pipeline("r1", 2, method, subject.body, subject.calibration, Untimed())


def run(pipeline: Pipeline, subject: Subject) -> list[Step]:
    size_px = subject.calibration.width_px, subject.calibration.height_px
    return [pipeline.step(frame.stored.stamp_ns, captured(frame.stored, size_px).picture, frame.wheels) for frame in subject.frames(FRAMES)]


@pytest.mark.parametrize(("method", "kind"), [("full", FullMethod), ("paper", PaperMethod), ("paper-calibrated", PaperMethod)])
def test_a_name_makes_its_method(method: Method, kind: type[Pipeline], subject: Subject) -> None:
    assert type(named(method, subject)) is kind


def test_the_papers_methods_differ_in_their_lens_only(subject: Subject) -> None:
    lenses = {"paper": hemispherical_projection(subject.calibration), "paper-calibrated": calibrated_projection(subject.calibration)}
    by_hand = {
        name: run(PaperMethod("r1", 2, subject.body, subject.calibration, lens, Untimed()), subject) for name, lens in lenses.items()
    }
    assert run(named("paper", subject), subject) == by_hand["paper"]
    assert run(named("paper-calibrated", subject), subject) == by_hand["paper-calibrated"]
    assert by_hand["paper"] != by_hand["paper-calibrated"]


@pytest.mark.parametrize("method", get_args(Method))
def test_every_method_reports_as_the_robot_it_was_made_for(method: Method, subject: Subject) -> None:
    for seq, step in enumerate(run(named(method, subject), subject)):
        assert (step.local_map.robot, step.local_map.epoch, step.local_map.seq) == ("r1", 2, seq)
        assert (step.vectors.robot, step.vectors.epoch, step.vectors.seq) == ("r1", 2, seq)
