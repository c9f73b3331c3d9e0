"""Reads an MCAP file of `loc-sim --mcap` or `loc-sim convert --to mcap` with two readers of others.

    loc-sim replay .. --mcap out.mcap
    python3 docs/scripts/read_mcap.py out.mcap [EXPECTED.json]

Every field of every message must be the same in both, bit by bit, infinity and NaN included. A file
EXPECTED.json says what they have to be: {topic: {field: [value of each message]}}, the field as
`pose.pose.position.x`, numbers that JSON does not know as "inf", "-inf" and "nan".

Needs the PyPI packages mcap-ros2-support and rosbags; says so and ends well where they are missing.
"""

import json
import struct
import sys
from collections import Counter, defaultdict
from dataclasses import fields, is_dataclass
from pathlib import Path


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
        if len(value) == 0:
            return into
        if isinstance(value[0], (int, float)) or hasattr(value, "dtype"):
            numbers = [float(number) for number in value]
            into.append(struct.pack(f"<{len(numbers)}d", *numbers))
        else:
            for element in value:
                flat(element, into)
    else:
        into.append(struct.pack("<d", float(value)))
    return into


def bits(value):
    """A value of a message or of JSON with its numbers as bits, every NaN the same."""
    if isinstance(value, str) and value not in ("inf", "-inf", "nan"):
        return value
    if isinstance(value, (list, tuple)) or hasattr(value, "dtype") and value.ndim > 0:
        return [bits(element) for element in value]
    number = float(value)
    return "nan" if number != number else struct.pack("<d", number)


def field(message, path):
    for name in path.split("."):
        message = message[int(name)] if name.isdigit() else getattr(message, name)
    return message


def compare_with(expected, found):
    """How many fields are not what they have to be, with a line for each."""
    wrong = 0
    for topic, of_topic in expected.items():
        for path, values in of_topic.items():
            for reader, messages in found.items():
                read = [field(message, path) for message in messages[topic]]
                if bits(read) != bits(values):
                    wrong += 1
                    print(f"{reader}: {topic} {path}: expected {values}, got {read}")
    return wrong


def main(path, expected=None):
    try:
        from mcap.reader import make_reader
        from mcap_ros2.reader import read_ros2_messages
        from rosbags.typesys import Stores, get_typestore, get_types_from_msg
    except ImportError as missing:
        print(f"skipped: {missing.name} is not installed (pip install mcap-ros2-support rosbags)")
        return 0
    with open(path, "rb") as file:
        # Checks the checksums of chunks; those of data and summary are checked by a stream reader.
        summary = make_reader(file, validate_crcs=True).get_summary()
    check_crcs(path)
    schemas = {s.name: s.data.decode() for s in summary.schemas.values()}
    undefined = {name for name, text in schemas.items() if not text}
    defined = [c.topic for c in summary.channels.values()
               if summary.schemas[c.schema_id].name not in undefined]
    store = get_typestore(Stores.EMPTY)
    types = {}
    for name, text in schemas.items():
        if text:
            types.update(get_types_from_msg(text, name))
    store.register(types)
    first, found = defaultdict(list), {"mcap-ros2-support": defaultdict(list), "rosbags": defaultdict(list)}
    keep = set(expected or {})
    for message in read_ros2_messages(path, topics=defined):
        topic = message.channel.topic
        first[topic, message.log_time_ns].append(flat(message.ros_msg, []))
        if topic in keep:
            found["mcap-ros2-support"][topic].append(message.ros_msg)
    counts, differences = Counter(), 0
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            counts[f"{channel.topic} ({schema.name})"] += 1
            if schema.name in undefined:
                continue
            other = store.deserialize_cdr(message.data, schema.name)
            if channel.topic in keep:
                found["rosbags"][channel.topic].append(other)
            if flat(other, []) != first[channel.topic, message.log_time].pop(0):
                differences += 1
                print(f"differs: {channel.topic} at {message.log_time}")
    for topic, count in sorted(counts.items()):
        print(f"{count:6} {topic}")
    total, indexed = sum(counts.values()), summary.statistics.message_count
    for name in sorted(undefined):
        print(f"not compared: {name}, whose definition is not in the file")
    print(f"{total} messages, {indexed} in the index, {differences} differ")
    wrong = compare_with(expected, found) if expected else 0
    if expected is not None:
        print(f"{sum(len(paths) for paths in expected.values())} fields expected, {wrong} wrong")
    return 0 if differences == 0 and wrong == 0 and total == indexed else 1


def check_crcs(path):
    """Reads the file as a stream, which checks every checksum there is; raises where one is wrong."""
    from mcap.stream_reader import StreamReader

    with open(path, "rb") as file:
        for _ in StreamReader(file, validate_crcs=True).records:
            pass


if __name__ == "__main__":
    wanted = json.loads(Path(sys.argv[2]).read_text()) if len(sys.argv) > 2 else None
    sys.exit(main(sys.argv[1], wanted))
