"""Procedures in Python. Between ticks, a procedure observes an operation and acts on it by commands.

    class StopInAForbiddenStructure(Procedure):
        def observe(self, observation):
            if any(event.name == "forbidden-entered" for event in observation.events):
                self.complete("The burr entered a forbidden structure.")
                return [Command("remove-instrument")]
            return []

    outcome = perform(operation, StopInAForbiddenStructure(), positions, buttons=1)
"""

from __future__ import annotations

import operator
from typing import Any, Iterable, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core import Error, Event, Operation, Touches


class Command:
    """A command with its parameters, as `Operation.command` takes them."""

    def __init__(self, name: str, /, *, hand: int = 0, **parameters: Any) -> None:
        self.name, self.hand, self.parameters = name, hand, parameters

    def __repr__(self) -> str:
        return f"Command({self.name!r}, hand={self.hand}, **{self.parameters!r})"


class Observation(NamedTuple):
    """Input of Procedure.observe()."""

    operation: Operation  #: for queries; a procedure changes it by commands only
    touches: Touches  #: results of the ticks since the last observation
    events: list[Event]  #: since the last observation


class Procedure:
    """Base of procedures. Override `observe`, and call `complete` to end."""

    #: ticks between two observations
    interval: int = 20

    def __init__(self) -> None:
        self.reason: Optional[str] = None

    def start(self, operation: Operation) -> Iterable[Command]:
        """Returns the commands to execute before the first tick."""
        return []

    def observe(self, observation: Observation) -> Iterable[Command]:
        """Returns the commands to execute now, in their order."""
        raise NotImplementedError("The procedure does not override observe(). Define it.")

    def complete(self, reason: str) -> None:
        """Ends the procedure after the commands of this observation."""
        self.reason = reason


class Outcome(NamedTuple):
    """Result of `perform`."""

    reason: Optional[str]  #: argument of Procedure.complete(); None: the path ended first
    ticks: int  #: number of executed ticks
    refused: list[tuple[Command, str]]  #: commands that the state did not allow, with the reason


def perform(operation: Operation, procedure: Procedure, positions: ArrayLike, orientations: Optional[ArrayLike] = None,
            buttons: Union[int, ArrayLike] = 0) -> Outcome:
    """Moves the hands along a path, as `Operation.run` does, and lets the procedure act every `interval` ticks.

    A command that the state does not allow does not end the procedure; the outcome lists it. Invalid commands raise.
    """
    path: NDArray[np.float64] = np.asarray(positions, float)
    turns = None if orientations is None else np.asarray(orientations, float)
    pressed = np.asarray(buttons)
    if path.ndim not in (2, 3) or path.shape[-1] != 3:
        raise ValueError("positions must have the shape (ticks, 3) or (ticks, hands, 3).")
    if turns is not None and turns.shape != (*path.shape[:-1], 4):
        raise ValueError("orientations must have the shape of positions, with four numbers each.")
    if pressed.ndim > 0 and pressed.shape != path.shape[:-1]:
        raise ValueError("buttons must be one number, or one per pose.")
    interval = operator.index(procedure.interval)
    if interval < 1:
        raise ValueError("The interval of a procedure must be a positive number of ticks.")
    refused: list[tuple[Command, str]] = []

    def execute(commands: Iterable[Command], method: str) -> None:
        if isinstance(commands, (Command, str)) or not hasattr(commands, "__iter__"):
            raise TypeError(f"{method}() must return a list of Command, not {type(commands).__name__}.")
        for command in commands:
            if not isinstance(command, Command):
                raise TypeError(f"{method}() must return a list of Command; one of them is {command!r}.")
            try:
                operation.command(command.name, hand=command.hand, **command.parameters)
            except Error as error:
                if not error.is_refusal:
                    raise
                refused.append((command, str(error)))

    procedure.reason = None
    execute(procedure.start(operation), "start")
    known = operation.event_count
    done = 0
    while done < len(path) and procedure.reason is None:
        part = slice(done, min(done + interval, len(path)))
        touches = operation.run(path[part], None if turns is None else turns[part],
                                buttons if pressed.ndim == 0 else pressed[part])
        done = part.stop
        events = operation.events_since(known)
        known += len(events)
        execute(procedure.observe(Observation(operation, touches, events)), "observe")
    return Outcome(procedure.reason, done, refused)
