"""What an MCAP file holds, by the readers of MCAP and ROS 2 messages from PyPI. Run: python topics.py FILE; prints JSON."""

import json
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory


def main():
    topics, states, statuses = {}, {}, {}
    with open(sys.argv[1], "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            topic = topics.setdefault(
                channel.topic, {"schema": schema.name, "messages": 0, "in_order": True, "last_ns": 0}
            )
            topic["messages"] += 1
            topic["in_order"] &= topic["last_ns"] <= message.log_time
            topic["last_ns"] = message.log_time
            stamp = decoded.header.stamp.sec * 10**9 + decoded.header.stamp.nanosec
            assert stamp == message.log_time, (stamp, message.log_time)
            if schema.name == "diagnostic_msgs/msg/DiagnosticArray":
                rows = statuses.setdefault(channel.topic, [])
                for status in decoded.status:
                    values = {pair.key: pair.value for pair in status.values}
                    level = status.level if isinstance(status.level, int) else status.level[0]
                    rows.append([message.log_time, level, status.name, status.message, status.hardware_id, values])
            else:
                for name, effort in zip(decoded.name, decoded.effort, strict=True):
                    states.setdefault(channel.topic, {}).setdefault(name, []).append(effort)
    json.dump({"topics": topics, "efforts": states, "statuses": statuses}, sys.stdout)


main()
