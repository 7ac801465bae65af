"""A program that subscribes to topics by DDS and prints what arrives, one JSON object a line:

python dds_reader.py DOMAIN TOPIC=package/Name...
"""

import json
import sys
import time
import types

from cyclonedds import builtin, core, domain, sub, topic
from cyclonedds.qos import Policy, Qos

from larics_host.ros.dds import type_of
from larics_host.ros.wire_types import wire_structs

CONFIGURATION = """<CycloneDDS><Domain Id="any"><General><Interfaces>
<NetworkInterface name="lo" multicast="false"/></Interfaces><AllowMulticast>false</AllowMulticast></General>
<Discovery><Peers><Peer Address="127.0.0.1"/></Peers><ParticipantIndex>auto</ParticipantIndex></Discovery>
</Domain></CycloneDDS>"""
LATCHED = ("/map", "/tf_static")


def reader_of(participant, name, kind):
    made = type_of(kind, wire_structs(), {})
    made.deserialize = classmethod(lambda _, data, **__: types.SimpleNamespace(data=bytes(data)))
    kept = Policy.Durability.TransientLocal if name.endswith(LATCHED) else Policy.Durability.Volatile
    qos = Qos(
        Policy.Reliability.Reliable(100_000_000),
        Policy.History.KeepLast(100),
        kept,
        Policy.DataRepresentation(use_cdrv0_representation=True),
    )
    return sub.DataReader(participant, topic.Topic(participant, "rt" + name, made, qos=qos), qos=qos)


def main(number, *wanted):
    where = domain.Domain(int(number), CONFIGURATION)
    participant = domain.DomainParticipant(int(number))
    pairs = [one.split("=") for one in wanted]
    readers = {name: reader_of(participant, name, kind) for name, kind in pairs}
    publications = builtin.BuiltinDataReader(participant, builtin.BuiltinTopicDcpsPublication)
    while where:
        for one in publications.take(100):
            if one.sample_info.valid_data:
                user = [policy.data.decode() for policy in one.qos if "Userdata" in str(type(policy))]
                print(json.dumps({"found": one.topic_name, "type": one.type_name, "user": user}), flush=True)
        for name, reader in readers.items():
            for one in reader.take(100):
                if one.sample_info.valid_data:
                    print(json.dumps({"topic": name, "data": one.data.hex()}), flush=True)
        time.sleep(0.01)


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except (BrokenPipeError, core.DDSException):
        sys.exit(1)
