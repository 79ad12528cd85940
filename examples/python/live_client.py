#!/usr/bin/env python3
"""Streams a recording (EuRoC or TUM layout) to `plumbline live`; standard library only.

  live_client.py room --speed 0 | plumbline live --config rgbd/points/window --wait
  live_client.py room --connect 4711           prints the estimates that come back, one line of JSON each

The framing is that of docs/guide/live.md.
"""

import argparse
import heapq
import socket
import struct
import sys
import threading
import time
import zlib
from pathlib import Path

CALIBRATION, IMU, FRAME, DEPTH, END = 1, 2, 3, 4, 5
CAMERA_TEXT, IMU_TEXT = 1, 2  # encodings of a calibration
IMAGE_FILE = 2  # encoding of an image: PNG or JPEG; 1 is raw pixels


def message(kind, payload=b"", encoding=0):
    """A header of 16 bytes and the payload."""
    header = b"PLBL" + struct.pack("<BBHI", 1, kind, encoding, len(payload))
    return header + struct.pack("<I", zlib.crc32(payload, zlib.crc32(header))) + payload


def rows(file):
    for line in file.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            yield line.replace(",", " ").split()


def nanoseconds(seconds):
    whole, _, fraction = seconds.partition(".")
    return int(whole) * 1_000_000_000 + int(fraction[:9].ljust(9, "0"))


def image_size(data):
    """Width and height that a PNG or JPEG states."""
    if data.startswith(b"\x89PNG"):
        return struct.unpack(">II", data[16:24])
    at = 2
    while at + 9 <= len(data):  # JPEG: segments up to the frame header
        marker, length = struct.unpack(">xBH", data[at : at + 4])
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        at += 2 + length
    raise ValueError("neither a PNG nor a JPEG")


def image(kind, t_ns, file):
    data = file.read_bytes()
    return message(kind, struct.pack("<qII", t_ns, *image_size(data)) + data, IMAGE_FILE)


def imu(t_ns, values):
    return message(IMU, struct.pack("<q6d", t_ns, *(float(value) for value in values[:6])))


class EuRoC:
    def __init__(self, folder):
        self.root = folder / "mav0" if (folder / "mav0").is_dir() else folder

    def calibrations(self):
        yield message(CALIBRATION, (self.root / "cam0/sensor.yaml").read_bytes(), CAMERA_TEXT)
        if (self.root / "imu0/sensor.yaml").exists():
            yield message(CALIBRATION, (self.root / "imu0/sensor.yaml").read_bytes(), IMU_TEXT)

    def imu_samples(self):
        if (self.root / "imu0/data.csv").exists():
            for row in rows(self.root / "imu0/data.csv"):
                yield int(row[0]), 0, imu(int(row[0]), row[1:])

    def frames(self):
        for row in rows(self.root / "cam0/data.csv"):
            yield int(row[0]), 1, image(FRAME, int(row[0]), self.root / "cam0/data" / row[1])


class Tum:
    def __init__(self, folder):
        self.root = folder

    def calibrations(self):
        yield message(CALIBRATION, (self.root / "calibration.yaml").read_bytes(), CAMERA_TEXT)

    def imu_samples(self):
        if (self.root / "imu.csv").exists():
            for t, *values in rows(self.root / "imu.csv"):
                yield nanoseconds(t), 0, imu(nanoseconds(t), values)

    def frames(self):
        depth = dict(rows(self.root / "depth.txt")) if (self.root / "depth.txt").exists() else {}
        times = {nanoseconds(t): file for t, file in depth.items()}
        for t, file in rows(self.root / "rgb.txt"):
            t_ns = nanoseconds(t)
            of_depth = b""
            if times:
                nearest = min(times, key=lambda other: abs(other - t_ns))
                if abs(nearest - t_ns) <= 20_000_000:
                    of_depth = image(DEPTH, t_ns, self.root / times[nearest])  # has the time stamp of its frame
            yield t_ns, 1, of_depth + image(FRAME, t_ns, self.root / file)


def connect(address):
    if address.isdigit():
        return socket.create_connection(("127.0.0.1", int(address)))
    out = socket.socket(socket.AF_UNIX)
    out.connect(address)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--connect", help="port of 127.0.0.1, or path of a Unix socket; else standard output")
    parser.add_argument("--speed", type=float, default=1, help="of the recording; 0: as fast as it is read")
    options = parser.parse_args()

    recording = Tum(options.recording) if (options.recording / "rgb.txt").exists() else EuRoC(options.recording)
    link = connect(options.connect) if options.connect else None
    send = link.sendall if link else sys.stdout.buffer.write

    def print_estimates():
        for line in link.makefile("r"):
            print(line, end="", flush=True)

    printing = threading.Thread(target=print_estimates) if link else None
    if printing:
        printing.start()  # at once: a program that cannot write does not read
    for calibration in recording.calibrations():
        send(calibration)
    first_ns, begin = None, time.monotonic()
    for t_ns, _, data in heapq.merge(recording.imu_samples(), recording.frames(), key=lambda item: item[:2]):
        first_ns = t_ns if first_ns is None else first_ns
        if options.speed > 0:
            time.sleep(max(0.0, begin + (t_ns - first_ns) * 1e-9 / options.speed - time.monotonic()))
        send(data)
    send(message(END))
    if not link:
        sys.stdout.buffer.flush()
    else:
        link.shutdown(socket.SHUT_WR)
        printing.join()


if __name__ == "__main__":
    try:
        main()
    except BrokenPipeError:
        sys.exit("live_client.py: the other end is gone")
    except (OSError, ValueError) as error:
        sys.exit(f"live_client.py: {error}")
