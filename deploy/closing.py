"""The account of a run that is over, with what map server, agents and recorder have to tell of it."""

from __future__ import annotations

from collections.abc import Mapping

from deploy.account import PaceAccount, RunAccount, robot_account
from deploy.recorder import Recorder
from protocol.settings import Settings


def finished_account(
    account: RunAccount, recorded: Mapping[str, int], settings: Mapping[str, Settings], recorder: Recorder, pace: PaceAccount
) -> RunAccount:
    """Return the account, completed; `recorded` is how many frames each robot's camera took, `settings` those of each process."""
    server, reports = recorder.server_report(), recorder.agent_reports()
    robots = {name: robot_account(frames, recorder.heard(name), reports[name], server) for name, frames in recorded.items()}
    configuration = {name: table.model_dump(mode="json", exclude_none=True) for name, table in settings.items()}
    return account.model_copy(update={"finished": True, "configuration": configuration, "robots": robots, "server": server, "pace": pace})
