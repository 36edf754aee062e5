"""Controls that choose a motion and its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import viser

from tsd_casadi.motions.declaration import Declaration
from tsd_casadi.wire.learner import EntryMessage
from tsd_clients.viewer.known_motion import KnownMotion, parameters_of, place_of
from tsd_clients.viewer.parameter_slider import ParameterSlider

NOTHING = "–"
# marks under a slider that still can be told apart
MARKS = 12


class MotionControls:
    """Dropdowns for motion and entries, and a slider for each parameter.

    Attributes:
        known: The chosen motion; None while nothing is known.
        parameters: The chosen values, SI units.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        """Add them to the page, invisible while there is nothing to choose."""
        self._gui = gui
        self._name = gui.add_dropdown("Motion", (NOTHING,), visible=False)
        self._group = gui.add_dropdown(
            "Learned along",
            (NOTHING,),
            hint="Entries that can be generalised together: same axes, body and formulation.",
            visible=False,
        )
        self._folder = gui.add_folder(None)
        self._entry = gui.add_dropdown(
            "Go to entry",
            (NOTHING,),
            hint="Set the sliders to where something was learned.",
            visible=False,
        )
        self._sliders: dict[str, viser.GuiSliderHandle[float]] = {}
        self._made_for: object = None
        self._motions: tuple[KnownMotion, ...] = ()
        self._declaration: Callable[[KnownMotion], Declaration | None] = lambda known: None
        self.known: KnownMotion | None = None
        self.parameters: dict[str, float] = {}

    def offer(
        self,
        motions: Sequence[KnownMotion],
        declaration: Callable[[KnownMotion], Declaration | None],
    ) -> None:
        """Offer other motions; what was chosen stays if it is still there.

        Args:
            motions: What was learned last first.
            declaration: Tells what is said of a motion.
        """
        self._motions, self._declaration = tuple(motions), declaration
        offer(self._name, [each.name for each in motions])
        self._made_for = None

    def update(self) -> None:
        """Take in what was chosen since the last time."""
        here = [each for each in self._motions if each.name == self._name.value]
        offer(self._group, [each.group for each in here])
        self._group.visible = len(here) > 1
        known = next((each for each in here if each.group == self._group.value), None)
        if known != self.known or (known is not None and self._made_for != known):
            self._choose(known)
        if known is None:
            return
        self._go_to_entry(known)
        self.parameters = {
            name: self._sliders[name].value if name in self._sliders else value
            for name, value in self.parameters.items()
        }

    def _choose(self, known: KnownMotion | None) -> None:
        before = self.parameters if _same(known, self.known) else {}
        self.known, self._made_for = known, known
        for slider in self._sliders.values():
            slider.remove()
        self._sliders = {}
        if known is None:
            self.parameters = {}
            return
        sliders = known.sliders(self._declaration(known))
        self.parameters = {each.name: before.get(each.name, each.start) for each in sliders}
        with self._folder:
            self._sliders = {
                each.name: self._slider(each, known) for each in sliders if each.is_movable
            }
        places = [NOTHING, *(entry_name(each) for each in known.entries)]
        self._entry.options = tuple(places)
        put(self._entry, NOTHING)
        self._entry.visible = True

    def _slider(self, each: ParameterSlider, known: KnownMotion) -> viser.GuiSliderHandle[float]:
        learned = sorted({entry.parameters[each.name].value for entry in known.entries})
        ends = {each.learned_low, each.learned_high}
        marks = tuple(
            (value, f"{value:g}") if value in ends else value
            for value in learned
            if value in ends or len(learned) <= MARKS
        )
        said = f"{each.meaning}; " if each.meaning else ""
        places = (
            f"learned from {each.learned_low:g} to {each.learned_high:g}"
            if each.varies
            else f"all entries have {each.learned_low:g}"
        )
        hint = f"{said}{places} {each.unit}"
        value = min(max(self.parameters[each.name], each.low), each.high)
        self.parameters[each.name] = value
        label = f"{each.name} [{each.unit}]" if each.unit else each.name
        return self._gui.add_slider(
            label, each.low, each.high, each.step, value, marks=marks, hint=hint.rstrip()
        )

    def _go_to_entry(self, known: KnownMotion) -> None:
        if self._entry.value == NOTHING:
            return
        chosen = next((e for e in known.entries if entry_name(e) == self._entry.value), None)
        put(self._entry, NOTHING)
        if chosen is None:
            return
        for name, value in parameters_of(chosen).items():
            self.parameters[name] = value
            if name in self._sliders:
                put(self._sliders[name], value)


def entry_name(entry: EntryMessage) -> str:
    """Name an entry, for people."""
    return f"{entry.entry}: {place_of(entry)}"


def _same(one: KnownMotion | None, other: KnownMotion | None) -> bool:
    """Whether values of the one make sense for the other."""
    if one is None or other is None:
        return False
    return (one.robot, one.motion, one.version) == (other.robot, other.motion, other.version)


def offer(dropdown: viser.GuiDropdownHandle[str], names: Sequence[str]) -> None:
    """Change what can be chosen; what was chosen stays if it is still there."""
    options = tuple(dict.fromkeys(names)) or (NOTHING,)
    if dropdown.options != options:
        before = dropdown.value
        dropdown.options = options
        put(dropdown, before if before in options else options[0])
    dropdown.visible = bool(names)


def put(control: Any, value: float | str) -> None:
    """Set what a control stands at; viser's annotations take that for read-only."""
    control.value = value
