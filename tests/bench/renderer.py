"""`python -m tests.bench.renderer`: milliseconds of processor time that the simulated cameras take for one frame, on one thread."""

from __future__ import annotations

import sys

from tests.bench.one_thread import stay_on_one_thread

SIZES_PX = ((1280, 960), (640, 480))
SEEDS, ROBOTS, FRAMES = range(1, 6), 3, 30


def main() -> int:
    """Measure random arenas at each size, and print a line for each size: median and 99th percentile."""
    stay_on_one_thread()
    from tests.bench.statistics import times

    for width_px, height_px in SIZES_PX:
        found = times([sample for seed in SEEDS for sample in _frames_ms(seed, width_px, height_px)])
        print(f"{width_px}x{height_px}: {found.p50_ms:5.1f} ms median, {found.p99_ms:5.1f} ms at the 99th percentile")
    return 0


def _frames_ms(seed: int, width_px: int, height_px: int) -> list[float]:
    """Return the milliseconds of frames of one arena, the robots' cameras taking turns."""
    from sim.arena import random_arena
    from sim.eyes import eyes_of
    from sim.staging import world_of
    from sim.world.cameras import Cameras
    from tests.bench.statistics import Stopwatch

    scenario = random_arena(seed, ROBOTS)
    camera = scenario.camera.model_copy(update={"width_px": width_px, "height_px": height_px})
    scenario = scenario.model_copy(update={"camera": camera})
    cameras, moment, watch = Cameras(eyes_of(scenario), seed), world_of(scenario).step(), Stopwatch()
    names = [placed.body.name for placed in moment.robots]
    for number in range(FRAMES):
        with watch.stage("frame"):
            cameras.picture(names[number % len(names)], moment)
    return watch.ms["frame"]


if __name__ == "__main__":
    sys.exit(main())
