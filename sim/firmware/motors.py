"""Motors on a bench: they follow their command with a first-order lag, and nothing holds the wheels up."""

from __future__ import annotations

from sim.world.drive import STILL, Drive, Turning, Wheels, turned

BENCH = Drive(
    wheel_base_m=0.2, radii_m=Wheels(0.035, 0.035), encoder_ticks_per_rev=1440, motor_lag_s=0.06, slip_m_per_sqrt_m=0.0
)  # a small robot of which nothing else is known


class LaggingMotors:
    """Two motors, from rest."""

    def __init__(self, drive: Drive, now_s: float) -> None:
        self._drive = drive
        self._command, self._turning, self._at_s = STILL, Turning(STILL, STILL), now_s

    def command(self, speeds_rad_s: Wheels, now_s: float) -> None:
        """Turn both wheels at these speeds from now on."""
        self._turning, self._at_s = self.turning(now_s), now_s
        self._command = speeds_rad_s

    def turning(self, now_s: float) -> Turning:
        """Return how the wheels turn now."""
        return turned(self._drive, self._turning, self._command, max(0.0, now_s - self._at_s))

    def push(self, angles_rad: Wheels) -> None:
        """Turn the wheels by hand, at once."""
        speeds, angles = self._turning
        self._turning = Turning(speeds, Wheels(angles.left + angles_rad.left, angles.right + angles_rad.right))
