"""Reads an MCAP file that `loc-sim --mcap` wrote with two readers of others, and compares.

    loc-sim replay .. --mcap out.mcap
    python3 docs/scripts/read_mcap.py out.mcap

Needs the PyPI packages mcap-ros2-support and rosbags; says so and ends well where they are missing.
Every field of every message must be the same in both, bit by bit, infinity and NaN included.
"""

import struct
import sys
from collections import Counter
from dataclasses import fields, is_dataclass


def flat(value, into):
    """The numbers, as bits, and texts of a message in order, whatever its classes are called."""
    names = getattr(value, "__slots__", None) if hasattr(value, "_type") else None
    if names is None:
        # rosbags has the constants of a type among its fields, in capitals.
        names = [f.name for f in fields(value) if not f.name.isupper()] if is_dataclass(value) else None
    if names is not None:
        for name in names:
            if not name.startswith("_"):
                flat(getattr(value, name), into)
    elif isinstance(value, str):
        into.append(value)
    elif hasattr(value, "__len__"):
        if len(value) > 0 and isinstance(value[0], (int, float)) or hasattr(value, "dtype"):
            numbers = [float(number) for number in value]
            into.append(struct.pack(f"<{len(numbers)}d", *numbers))
        else:
            for element in value:
                flat(element, into)
    else:
        into.append(struct.pack("<d", float(value)))
    return into


def main(path):
    try:
        from mcap_ros2.reader import read_ros2_messages
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore, get_types_from_msg
        from mcap.reader import make_reader
        from pathlib import Path
    except ImportError as missing:
        print(f"skipped: {missing.name} is not installed (pip install mcap-ros2-support rosbags)")
        return 0
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True)
        schemas = {s.name: s.data.decode() for s in reader.get_summary().schemas.values()}
        indexed = reader.get_summary().statistics.message_count
    store = get_typestore(Stores.EMPTY)
    types = {}
    for name, text in schemas.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    first = {}
    for message in read_ros2_messages(path):
        key = (message.channel.topic, message.log_time_ns)
        first.setdefault(key, []).append(flat(message.ros_msg, []))
    counts, differences = Counter(), 0
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            other = store.deserialize_cdr(message.data, schema.name)
            key = (channel.topic, message.log_time)
            counts[f"{channel.topic} ({schema.name})"] += 1
            if flat(other, []) != first[key].pop(0):
                differences += 1
                print(f"differs: {channel.topic} at {message.log_time}")
    for topic, count in sorted(counts.items()):
        print(f"{count:6} {topic}")
    total = sum(counts.values())
    print(f"{total} messages, {indexed} in the index, {differences} differ")
    return 0 if differences == 0 and total == indexed else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
