"""What a query for a feedforward or a suggestion asks, as text of a selector."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tsd_casadi.exceptions import InvalidValue, MalformedMessage, UnsupportedVersion
from tsd_casadi.learning.context import Context
from tsd_casadi.motions.parameter import RESERVED

MOST_TEXTS = 60
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.]{0,99}", re.ASCII)
_FINGERPRINT = re.compile(r"[A-Za-z0-9_.:+-]{0,200}", re.ASCII)
OPTIONS = ("motion", "version", "axes", "body", "formulation", "correction", "kind", "extrapolate")


@dataclass(frozen=True)
class Question:
    """A motion, which entries may answer, and texts for its parameters.

    Attributes:
        motion: Name of the motion.
        version: Of the motion; None for that of the newest recording.
        axes: Along which it is asked for; None for any.
        context: In which it is asked for; None for that of the newest recording.
        kind: 'learned', 'generalised' or None.
        extrapolate: Whether to generalise outside the learned range too.
        parameters: What is left, texts by name.
    """

    motion: str
    version: str | None
    axes: tuple[str, ...] | None
    context: Context | None
    kind: str | None
    extrapolate: bool
    parameters: dict[str, str]

    @classmethod
    def of(cls, texts: Mapping[str, str], example: str) -> Question:
        """Read the texts of a selector.

        Args:
            example: Of a good one, for errors.

        Raises:
            UnsupportedVersion: If it is a query of version 1.
            MalformedMessage: If there is no motion.
            InvalidValue: If a name or an option makes no sense.
        """
        if "task" in texts:
            raise UnsupportedVersion(
                "a query of version 1 ('task=')", f"'motion=' in place of it: {example}"
            )
        if "motion" not in texts:
            raise MalformedMessage("no motion in the query", example)
        if len(texts) > MOST_TEXTS:
            raise MalformedMessage(f"{len(texts)} fields in the query", f"at most {MOST_TEXTS}")
        axes = None
        if "axes" in texts:
            axes = tuple(_name("axes", text) for text in texts["axes"].split(","))
            if len(set(axes)) < len(axes):
                raise InvalidValue("axes", repr(texts["axes"]), "each axis once")
        kind = texts.get("kind")
        if kind not in (None, "learned", "generalised"):
            raise InvalidValue("kind", repr(kind), "learned or generalised")
        extrapolate = texts.get("extrapolate", "false").lower()
        if extrapolate not in ("true", "false"):
            raise InvalidValue("extrapolate", repr(extrapolate), "true or false")
        version = texts.get("version")
        return cls(
            motion=_name("motion", texts["motion"]),
            version=None if version is None else _fingerprint("version", version),
            axes=axes,
            context=_context(texts),
            kind=kind,
            extrapolate=extrapolate == "true",
            parameters={name: text for name, text in texts.items() if name not in OPTIONS},
        )

    def numbers(self) -> dict[str, float]:
        """Read the parameters; whether they make sense is for the database to say.

        Raises:
            InvalidValue: If one is no number.
        """
        return {name: number(name, text) for name, text in self.parameters.items()}


def question_texts(
    motion: str,
    parameters: Mapping[str, float],
    *,
    version: str | None,
    axes: Sequence[str] | None,
    context: Context | None,
) -> dict[str, str]:
    """Write a question as texts of a selector.

    Args:
        parameters: SI units.
        version: Of the motion; None for that of the newest recording.
        axes: Along which it is asked for; None for any.
        context: In which it is asked for; None for that of the newest recording.
    """
    texts = {"motion": motion, **{name: repr(float(v)) for name, v in parameters.items()}}
    if version is not None:
        texts["version"] = version
    if axes is not None:
        texts["axes"] = ",".join(axes)
    if context is not None:
        texts |= {
            "body": context.body,
            "formulation": context.formulation,
            "correction": context.correction,
        }
    return texts


def number(name: str, text: str) -> float:
    """Read a number of a motion's parameter.

    Raises:
        InvalidValue: If it is none, or the name is that of something else.
    """
    if name in RESERVED or _NAME.fullmatch(name) is None:
        raise InvalidValue(
            f"parameter {name[:100]!r}", repr(text[:100]), "the name of a motion's parameter"
        )
    try:
        return float(text)
    except ValueError:
        raise InvalidValue(name, repr(text[:100]), "a number in SI units") from None


def _context(texts: Mapping[str, str]) -> Context | None:
    named = [name for name in ("body", "formulation", "correction") if name in texts]
    if not named:
        return None
    if not {"body", "formulation"} <= set(named):
        raise InvalidValue(
            "the context", f"of {' and '.join(named)} only", "body and formulation, or none of them"
        )
    return Context(**{name: _fingerprint(name, texts[name]) for name in named})


def _name(field: str, text: str) -> str:
    if _NAME.fullmatch(text) is None:
        raise InvalidValue(field, repr(text[:100]), "a name of letters, digits, _ and .")
    return text


def _fingerprint(field: str, text: str) -> str:
    if _FINGERPRINT.fullmatch(text) is None:
        raise InvalidValue(field, repr(text[:100]), "letters, digits and _ . : + -")
    return text
