"""The JSON messages of the network, checked where they come in."""

from tsd_casadi.messages.feedforward import BasisMessage, FeedforwardMessage, QuantityMessage
from tsd_casadi.messages.info import FieldMessage, InfoMessage
from tsd_casadi.messages.learner import (
    ContextMessage,
    DatabaseReply,
    EntryMessage,
    LapMessage,
    RecordMessage,
    RecordReply,
)
from tsd_casadi.messages.message import ErrorMessage, Message, json_schema
from tsd_casadi.messages.suggestion import SuggestionMessage

__all__ = [
    "BasisMessage",
    "ContextMessage",
    "DatabaseReply",
    "EntryMessage",
    "ErrorMessage",
    "FeedforwardMessage",
    "FieldMessage",
    "InfoMessage",
    "LapMessage",
    "Message",
    "QuantityMessage",
    "RecordMessage",
    "RecordReply",
    "SuggestionMessage",
    "json_schema",
]
