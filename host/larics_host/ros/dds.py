"""Live topics by DDS, as ROS 2 names and types them, with Cyclone DDS; no ROS is needed.

Messages are encoded by `cdr`; Cyclone gets their types and the ready bytes. Only the loopback interface is
used unless the caller says otherwise.
"""

from __future__ import annotations

import contextlib
import os
import platform
import re
import sys
import tempfile
import types
from typing import TYPE_CHECKING, Any

from larics_host.errors import UserError, report_once
from larics_host.ros.cdr import encode
from larics_host.ros.topics import TRANSIENT_LOCAL, Qos, qos_of
from larics_host.ros.type_hash import type_hash
from larics_host.ros.wire_types import wire_structs

if TYPE_CHECKING:
    from collections.abc import Mapping

    from larics_host.ros.definitions import Struct
    from larics_host.ros.topics import Output

_BLOCKED_MS = 100

LOOPBACK = """<CycloneDDS><Domain Id="any">
<General><Interfaces><NetworkInterface name="{interface}" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General>
<Discovery><Peers><Peer Address="127.0.0.1"/></Peers><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex></Discovery>
<Tracing><Verbosity>none</Verbosity></Tracing>
</Domain></CycloneDDS>"""
INTERFACE = """<CycloneDDS><Domain Id="any">
<General><Interfaces><NetworkInterface name="{interface}"/></Interfaces></General>
<Tracing><Verbosity>none</Verbosity></Tracing>
</Domain></CycloneDDS>"""


def dds_topic(topic: str) -> str:
    """The DDS topic of a ROS topic."""
    return "rt" + topic


def dds_type(name: str) -> str:
    """ "package::msg::dds_::Name_" of "package/Name"."""
    package, _, kind = name.partition("/")
    return "%s::msg::dds_::%s_" % (package, kind)


def _modules():
    try:
        from cyclonedds import core, domain, idl, pub, qos, topic
        from cyclonedds.idl import annotations
        from cyclonedds.idl import types as kinds
    except ImportError as error:
        machine = "%s on %s" % (platform.system(), platform.machine())
        raise UserError(
            'larics ros2 needs the Python package cyclonedds: pip install "larics[ros]"; there '
            "are wheels for x86-64 alone (here: %s), elsewhere build it, or record with larics log --bag (%s)"
            % (machine, error)
        ) from None
    return types.SimpleNamespace(
        core=core,
        domain=domain,
        idl=idl,
        pub=pub,
        qos=qos,
        topic=topic,
        annotations=annotations,
        kinds=kinds,
    )


def configuration(interface: str | None, network: bool) -> str | None:
    """The configuration of Cyclone DDS as XML: loopback alone; one interface; with `network` None, which
    leaves it to CYCLONEDDS_URI or to Cyclone's own choice."""
    if interface is not None:
        return INTERFACE.format(interface=interface)
    return None if network else LOOPBACK.format(interface="lo" if os.name == "posix" else "Loopback")


class Publisher:
    """Topics of one ROS domain. UserError when the package is missing, or DDS cannot be had there."""

    def __init__(self, domain: int, interface: str | None = None, network: bool = False) -> None:
        self._dds = _modules()
        self._structs = wire_structs()
        self._writers: dict[str, Any] = {}
        self._types: dict[str, Any] = {}
        text = configuration(interface, network)
        where = "the interface %s" % interface if interface else "the network" if network else "loopback"
        said: list[str] = []
        try:
            with _listening(said):
                self._domain = self._dds.domain.Domain(domain, text) if text is not None else None
                self._participant = self._dds.domain.DomainParticipant(domain)
        except self._dds.core.DDSException as error:
            why = "; ".join(said) or _first_line(error)
            raise UserError("DDS does not start on %s, domain %d: %s" % (where, domain, why)) from None

    def write(self, output: Output) -> None:
        """Publishes one message. UserError when DDS refuses it."""
        data = encode(output.type, output.value, self._structs)
        try:
            writer = self._writers.get(output.topic) or self._new_writer(output.topic, output.type)
            kind = self._types[output.type]
            sample = kind.__new__(kind)
            sample.ready = data
            writer.write(sample)
        except self._dds.core.DDSException as error:
            if error.code == error.DDS_RETCODE_TIMEOUT:  # the line is read on whatever others do
                report_once(
                    ("slow", output.topic), "a subscriber of %s is too slow: it misses some" % output.topic
                )
                return
            raise UserError("DDS refuses %s: %s" % (output.topic, _first_line(error))) from None

    def announce(self, topics: dict[str, str]) -> None:
        """Makes topics {name: type} known before there is anything to say."""
        for topic, kind in topics.items():
            self._new_writer(topic, kind)

    def close(self) -> None:
        """Leaves the domain."""
        self._writers.clear()
        self._participant = self._domain = None

    def _new_writer(self, topic, kind):
        made = type_of(kind, self._structs, self._types)
        made.serialize = _ready
        qos = self._qos(qos_of(topic), kind)
        found = self._dds.topic.Topic(self._participant, dds_topic(topic), made, qos=qos)
        self._writers[topic] = self._dds.pub.DataWriter(self._participant, found, qos=qos)
        return self._writers[topic]

    def _qos(self, wanted: Qos, kind):
        policy = self._dds.qos.Policy
        kept = wanted.durability == TRANSIENT_LOCAL
        return self._dds.qos.Qos(
            policy.Reliability.Reliable(_BLOCKED_MS * 1_000_000),
            policy.History.KeepLast(wanted.depth),
            policy.Durability.TransientLocal if kept else policy.Durability.Volatile,
            policy.DataRepresentation(use_cdrv0_representation=True),
            policy.Userdata(("typehash=%s;" % type_hash(kind, self._structs)).encode()),
        )


def _ready(sample, *_, **__):
    """In place of Cyclone's own encoding, which costs fifty times as much."""
    return sample.ready


@contextlib.contextmanager
def _listening(said):
    """Collects what Cyclone prints to standard error by itself: the cause of what it then refuses."""
    sys.stderr.flush()
    before = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(before, 2)
            os.close(before)
            file.seek(0)
            for line in file.read().decode(errors="replace").splitlines():
                # "1795714185.139226 [0]     larics: failed to find interfaces"
                said.append(re.sub(r"^[\d.]+ \[\d+\]\s+\S+: ", "", line).strip())


def _first_line(error):
    return (str(error).splitlines() or [type(error).__name__])[0].strip()


def type_of(name: str, structs: Mapping[str, Struct], known: dict[str, Any]) -> Any:
    """Cyclone's type of "package/Name"; `known` keeps those that were made. UserError without the package."""
    if name not in known:
        dds = _modules()
        fields = {field.name: _field_type(dds, field, structs, known) for field in structs[name].fields}
        made = dds.idl.make_idl_struct(
            name.rpartition("/")[2] + "_", dds_type(name).replace("::", "."), fields
        )
        known[name] = dds.annotations.final(made)
    return known[name]


def _field_type(dds, field, structs, known):
    kinds = dds.kinds
    if field.type in structs:
        one = type_of(field.type, structs, known)
    elif field.type in ("string", "bool"):
        one = {"string": str, "bool": bool}[field.type]
    else:
        one = getattr(kinds, "uint8" if field.type == "byte" else field.type)
    if field.length is None:
        return one
    return kinds.array[one, field.length] if field.length else kinds.sequence[one]
