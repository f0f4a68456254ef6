"""Orders to an emulated board's surroundings, one a line: what befalls its serial line, its sensors and its wheels."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from sim.firmware.board import Maker, Motors
from sim.firmware.port import SerialPort


class Surroundings:
    """A board on its port, its motors, and what else could be on that port."""

    def __init__(self, port: SerialPort, motors: Motors, makers: Mapping[str, Maker]) -> None:
        self._port, self._motors, self._makers = port, motors, makers

    def carry_out(self, order: str, now_s: float) -> str:
        """Carry out an order and return the answer, one line that begins with `ok`, or with `refused` and the reason."""
        word, *values = order.split() or [""]
        if word not in ORDERS:
            return f"refused: {word or 'an empty line'} is no order; there are {', '.join(ORDERS)}"
        try:
            return f"ok {ORDERS[word](self, values, now_s)}".rstrip()
        except (ValueError, IndexError, KeyError) as error:
            return f"refused: {order} ({error})"

    def unplug(self, _values: list[str], _now_s: float) -> str:
        """`unplug`."""
        self._port.unplug()
        return ""

    def plug(self, _values: list[str], _now_s: float) -> str:
        """`plug`."""
        self._port.plug()
        return ""

    def reboot(self, _values: list[str], now_s: float) -> str:
        """`reboot`: the board loses power for a moment."""
        self._port.board.reboot(now_s)
        return ""

    def device(self, values: list[str], now_s: float) -> str:
        """`device NAME`: another board or device is on the same port from now on."""
        self._port.board = self._makers[values[0]](self._motors, now_s)
        return ""

    def lost(self, values: list[str], _now_s: float) -> str:
        """`lost SHARE` of the bytes, in both directions."""
        self._port.faults.lost_share = _share(values[0])
        return ""

    def garbled(self, values: list[str], _now_s: float) -> str:
        """`garbled SHARE` of the bytes, in both directions."""
        self._port.faults.garbled_share = _share(values[0])
        return ""

    def delay(self, values: list[str], _now_s: float) -> str:
        """`delay SECONDS` before every answer."""
        self._port.faults.delay_s = max(0.0, float(values[0]))
        return ""

    def echo(self, values: list[str], _now_s: float) -> str:
        """`echo on` or `echo off`."""
        self._port.faults.echo = {"on": True, "off": False}[values[0]]
        return ""

    def sense(self, values: list[str], _now_s: float) -> str:
        """`sense SENSOR VALUE`, numbered as the firmware numbers its sensors."""
        self._port.board.sense(int(values[0]), int(values[1]))
        return ""

    def wheels(self, _values: list[str], now_s: float) -> str:
        """`wheels`: answered by both speeds [rad/s] and both angles [rad], left before right."""
        speeds, angles = self._motors.turning(now_s)
        return " ".join(f"{value:.4f}" for value in (*speeds, *angles))


ORDERS: dict[str, Callable[[Surroundings, list[str], float], str]] = {
    "unplug": Surroundings.unplug,
    "plug": Surroundings.plug,
    "reboot": Surroundings.reboot,
    "device": Surroundings.device,
    "lost": Surroundings.lost,
    "garbled": Surroundings.garbled,
    "delay": Surroundings.delay,
    "echo": Surroundings.echo,
    "sense": Surroundings.sense,
    "wheels": Surroundings.wheels,
}


def _share(text: str) -> float:
    share = float(text)
    if not 0.0 <= share <= 1.0:
        raise ValueError("a share is between 0 and 1")
    return share
