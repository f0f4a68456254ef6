"""A board's serial line as a pseudo-terminal under a name that stays, which can be unplugged and plugged back."""

from __future__ import annotations

import os
import select
import termios
import tty
from pathlib import Path

from sim.firmware.board import Board
from sim.firmware.line import Line, LineFaults

TURN_S = 0.004  # the board is turned at least so often
GRAIN_S = 0.001  # bytes come a few at a time, as from the chip of a serial adapter

_CHUNK = 4096
_SPEEDS = {baud: getattr(termios, f"B{baud}") for baud in (300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200)}
_OUTPUT_SPEED = 5  # in what tcgetattr returns


class SerialPort:
    """Plugged in from the beginning. Use it as a context manager: the name goes with it, and the line hangs up.

    Whoever services it gives the time, on any monotonic clock [s]. A client that has set another speed than the board's reads garbage.
    """

    def __init__(self, board: Board, name: Path, faults: LineFaults | None = None) -> None:
        self.board, self.faults = board, faults or LineFaults()
        self._name = name
        self._to_board, self._from_board = Line(self.faults, seed=1), Line(self.faults, seed=2)
        self._master: int | None = None
        self._opened = False
        self.plug()

    @property
    def readable(self) -> tuple[int, ...]:
        """The descriptor on which a client's bytes come, while there is a client."""
        return (self._master,) if self._master is not None and self._opened else ()

    def plug(self) -> None:
        """Put the line back under its name; does nothing where it is plugged in."""
        if self._master is not None:
            return
        self._master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self._master, False)
        target = os.ttyname(slave)
        os.close(slave)  # from here on the master tells whether somebody has opened the line
        self._name.unlink(missing_ok=True)
        self._name.symlink_to(target)

    def unplug(self) -> None:
        """Take the line away under its client; the board goes on. Does nothing where it is unplugged."""
        if self._master is None:
            return
        self._name.unlink(missing_ok=True)
        os.close(self._master)
        self._master, self._opened = None, False
        self._to_board.cut()
        self._from_board.cut()

    def due_s(self, now_s: float) -> float:
        """Return until when nothing has to be done but for a client's bytes; what is due sooner than in a grain of time waits for that."""
        return min(now_s + TURN_S, max(now_s + GRAIN_S, min(self._to_board.due_s, self._from_board.due_s)))

    def service(self, now_s: float) -> None:
        """Carry bytes both ways and turn the board until now."""
        self._receive(now_s)
        for byte, at_s in self._to_board.take(now_s):
            self._send(self.board.turn(at_s), at_s)
            self._send(self.board.receive(byte, at_s), at_s + self.faults.delay_s)
        self._send(self.board.turn(now_s), now_s)
        self._deliver(now_s)

    def close(self) -> None:
        """Take the line away for good."""
        self.unplug()

    def _receive(self, now_s: float) -> None:
        """Take what a client has sent, and note where one comes or goes."""
        if self._master is None:
            return
        opened = not _hung_up(self._master)
        if opened and not self._opened:
            self.board.opened(now_s)
        self._opened = opened
        if not opened:
            self._from_board.cut()
            return
        try:
            data = os.read(self._master, _CHUNK)
        except OSError:  # nothing there, or the client has gone in this moment
            return
        self._to_board.put(data, now_s, self.board.baud, garbled=not self._same_speed())
        if self.faults.echo:
            self._send(data, now_s)

    def _send(self, data: bytes, from_s: float) -> None:
        if data and self.readable:
            self._from_board.put(data, from_s, self.board.baud, garbled=not self._same_speed())

    def _deliver(self, now_s: float) -> None:
        arrived = bytes(byte for byte, _ in self._from_board.take(now_s))
        if not arrived or self._master is None:
            return
        try:
            os.write(self._master, arrived)
        except OSError:  # a client that does not read, or has gone: the line waits for nobody
            return

    def _same_speed(self) -> bool:
        """Tell whether the client has set the line to the board's speed."""
        if self._master is None:
            return False
        return bool(termios.tcgetattr(self._master)[_OUTPUT_SPEED] == _SPEEDS.get(self.board.baud))

    def __enter__(self) -> SerialPort:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _hung_up(master: int) -> bool:
    """Tell whether nobody has opened the other end."""
    poll = select.poll()
    poll.register(master, select.POLLIN)
    return any(events & select.POLLHUP for _, events in poll.poll(0))
