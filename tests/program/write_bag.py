"""Writes a recording (EuRoC or TUM RGB-D layout) as a bag.

  write_bag.py RECORDING OUT.bag [--compression none|bz2|lz4] [--compressed-images] [--duration S] [--no-imu]

The images are written as messages of pixels, or as the files that they are (--compressed-images). OUT.bag is written by
ROS's own rosbag; OUT.db3 is the database that rosbag2 makes; OUT.jsonl has a line for each message, for write_mcap.mjs.
"""

import argparse
import base64
import json
import pathlib
import sqlite3
import struct

import numpy
import PIL.Image
import rosbag
import rospy
import sensor_msgs.msg


def rows(file):
    for line in file.read_text().splitlines():
        if line and not line.startswith("#"):
            yield line.replace(",", " ").split()


def nanoseconds(text, is_seconds):
    if not is_seconds:
        return int(text)
    whole, _, rest = text.partition(".")
    return int(whole) * 10**9 + int(rest.ljust(9, "0")[:9])


def events(folder, arguments):
    """(time, topic, content), in order of time; an image is (file)."""
    out = []
    is_tum = (folder / "rgb.txt").exists()
    if is_tum:
        sources = [("/camera/image_raw", folder / "rgb.txt", folder), ("/camera/depth/image_raw", folder / "depth.txt", folder)]
        imu = folder / "imu.csv"
    else:
        sources = [("/cam0/image_raw", folder / "mav0/cam0/data.csv", folder / "mav0/cam0/data")]
        imu = folder / "mav0/imu0/data.csv"
    for topic, index, base in sources:
        if index.exists():
            out += [(nanoseconds(row[0], is_tum), topic, base / row[1]) for row in rows(index)]
    end = min(event[0] for event in out) + int(arguments.duration * 1e9)
    if imu.exists() and not arguments.no_imu:
        out += [(nanoseconds(row[0], is_tum), "/imu0", [float(x) for x in row[1:7]]) for row in rows(imu)]
    return sorted((event for event in out if event[0] <= end), key=lambda event: (event[0], event[1]))


def pixels(file):
    image = PIL.Image.open(file)
    array = numpy.array(image)
    if array.ndim == 3:
        return "rgb8", array[:, :, :3].astype(numpy.uint8)
    return ("mono8", array.astype(numpy.uint8)) if image.mode == "L" else ("16UC1", array.astype("<u2"))


def message(t_ns, topic, content, arguments):
    stamp = rospy.Time(t_ns // 10**9, t_ns % 10**9)
    if topic == "/imu0":
        out = sensor_msgs.msg.Imu()
        out.angular_velocity.x, out.angular_velocity.y, out.angular_velocity.z = content[:3]
        out.linear_acceleration.x, out.linear_acceleration.y, out.linear_acceleration.z = content[3:]
    elif arguments.compressed_images:
        out = sensor_msgs.msg.CompressedImage()
        out.data = content.read_bytes()
        depth = "depth" in topic
        out.format = ("16UC1; compressed " if depth else "mono8; jpeg compressed ") + content.suffix[1:]
    else:
        out = sensor_msgs.msg.Image()
        out.encoding, array = pixels(content)
        out.height, out.width = array.shape[:2]
        out.step = array.strides[0]
        out.data = array.tobytes()
    out.header.stamp = stamp
    out.header.frame_id = "camera"
    return out


def camera_info(t_ns, arguments):
    width, height, fx, fy, cx, cy, *distortion = (float(x) for x in arguments.camera.split(","))
    out = sensor_msgs.msg.CameraInfo()
    out.header.stamp = rospy.Time(t_ns // 10**9, t_ns % 10**9)
    out.width, out.height = int(width), int(height)
    out.distortion_model = "plumb_bob"
    out.D = distortion
    out.K = [fx, 0, cx, 0, fy, cy, 0, 0, 1]
    return out


def write_ros1(file, messages, arguments):
    with rosbag.Bag(str(file), "w", compression=arguments.compression, chunk_threshold=arguments.chunk) as bag:
        for t_ns, topic, each in messages:
            # Recorded later than it was measured, as messages are.
            bag.write(topic, each, rospy.Time.from_sec(t_ns * 1e-9 + 0.003))


class Cdr:
    """Little endian, each number aligned to its size."""

    def __init__(self):
        self.bytes = bytearray(b"\x00\x01\x00\x00")

    def add(self, kind, *values):
        for value in values:
            while (len(self.bytes) - 4) % struct.calcsize(kind):
                self.bytes.append(0)
            self.bytes += struct.pack("<" + kind, value)

    def text(self, value):
        self.add("I", len(value) + 1)
        self.bytes += value.encode() + b"\0"

    def data(self, value):
        self.add("I", len(value))
        self.bytes += value


def cdr_of(each):
    out = Cdr()
    out.add("i", each.header.stamp.secs)
    out.add("I", each.header.stamp.nsecs)
    out.text(each.header.frame_id)
    kind = type(each).__name__.rpartition("_")[2]
    if kind == "Imu":
        out.add("d", 0, 0, 0, 1, *[0] * 9)
        out.add("d", each.angular_velocity.x, each.angular_velocity.y, each.angular_velocity.z, *[0] * 9)
        out.add("d", each.linear_acceleration.x, each.linear_acceleration.y, each.linear_acceleration.z, *[0] * 9)
    elif kind == "CompressedImage":
        out.text(each.format)
        out.data(each.data)
    elif kind == "Image":
        out.add("I", each.height, each.width)
        out.text(each.encoding)
        out.add("B", 0)
        out.add("I", each.step)
        out.data(each.data)
    else:
        out.add("I", each.height, each.width)
        out.text(each.distortion_model)
        out.add("I", len(each.D))
        out.add("d", *each.D, *each.K, *[0] * 21)
        out.add("I", *[0] * 6)
        out.add("B", 0)
    return bytes(out.bytes)


def type_of(each):
    return "sensor_msgs/msg/" + type(each).__name__.rpartition("_")[2]


def write_json(file, messages):
    with file.open("w") as out:
        for t_ns, topic, each in messages:
            data = base64.b64encode(cdr_of(each)).decode()
            json.dump({"topic": topic, "type": type_of(each), "t": str(t_ns + 3000000), "data": data}, out)
            out.write("\n")


def write_sqlite(file, messages):
    database = sqlite3.connect(str(file))
    database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
                     "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)")
    database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
                     "data BLOB NOT NULL)")
    database.execute("CREATE INDEX timestamp_idx ON messages (timestamp ASC)")
    ids = {}
    for t_ns, topic, each in messages:
        if topic not in ids:
            ids[topic] = len(ids) + 1
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (ids[topic], topic, type_of(each)))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                         (ids[topic], t_ns + 3000000, cdr_of(each)))
    database.commit()
    database.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--compression", default="none")
    parser.add_argument("--compressed-images", action="store_true")
    parser.add_argument("--duration", type=float, default=1e6)
    parser.add_argument("--chunk", type=int, default=768 * 1024)
    parser.add_argument("--no-imu", action="store_true")
    parser.add_argument("--camera", help="width,height,fx,fy,cx,cy,distortion... for CameraInfo")
    arguments = parser.parse_args()

    def messages():
        seen = set()
        for t_ns, topic, content in events(arguments.recording, arguments):
            if arguments.camera and topic.endswith("image_raw") and topic not in seen:
                seen.add(topic)
                yield t_ns, topic.rpartition("/")[0] + "/camera_info", camera_info(t_ns, arguments)
            yield t_ns, topic, message(t_ns, topic, content, arguments)

    if arguments.out.suffix == ".db3":
        write_sqlite(arguments.out, messages())
    elif arguments.out.suffix == ".jsonl":
        write_json(arguments.out, messages())
    else:
        write_ros1(arguments.out, messages(), arguments)


main()
