"""`plumbline live` on a stream of the recording: the poses of `run`, and faults of the stream by name.

live.py PROGRAM RECORDING CLIENT: three seconds of the simulated room, 320 x 240; examples/python/live_client.py
"""

import importlib.util
import json
import math
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
import zlib
from pathlib import Path

program, recording, client = sys.argv[1], Path(sys.argv[2]), sys.argv[3]
spec = importlib.util.spec_from_file_location("live_client", client)
live_client = importlib.util.module_from_spec(spec)
spec.loader.exec_module(live_client)
message = live_client.message
depth_config, imu_config = "rgbd/points/window", "mono-imu/points/window"


def stream_of(folder, speed="0"):
    return subprocess.run([sys.executable, client, folder, "--speed", speed], check=True, capture_output=True).stdout


def live(stream, *arguments, config=depth_config):
    return subprocess.run([program, "live", "--config", config, *arguments], input=stream, capture_output=True,
                          timeout=60)


def tum(line):
    whole, fraction = divmod(line["t_ns"], 1_000_000_000)
    return f"{whole}.{fraction:09d} " + " ".join(f"{x:.9f}" for x in line["position"]) + " " + " ".join(
        f"{x:.12f}" for x in line["quaternion"])


def estimates(output):
    return [line for line in map(json.loads, output.splitlines()) if "event" not in line]


def events(output):
    return [line for line in map(json.loads, output.splitlines()) if "event" in line]


class Live(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def start(self, *arguments, **options):
        """The program, which ends with the test."""
        process = subprocess.Popen([program, "live", "--config", depth_config, *arguments], stderr=subprocess.PIPE,
                                   stdout=subprocess.PIPE, **options)
        pipes = [pipe for pipe in (process.stdin, process.stdout, process.stderr) if pipe]
        for pipe in pipes:
            self.addCleanup(pipe.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def by_run(self, config, folder=recording, *arguments):
        out = self.folder / "run.tum"
        subprocess.run([program, "run", "--config", config, "--dataset", folder, "--trajectory", out, *arguments],
                       check=True, capture_output=True)
        return out.read_text()


class SamePoses(Live):
    def test_depth(self):
        out = self.folder / "live.tum"
        done = live(stream_of(recording), "--wait", "--trajectory", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        expected = self.by_run(depth_config)
        self.assertEqual(out.read_text(), expected)
        lines = estimates(done.stdout)
        self.assertEqual([tum(line) for line in lines if line["is_sound"]], expected.splitlines())
        self.assertEqual(len(lines[0]["covariance"]), 21)
        self.assertEqual(lines[-1]["health"], "tracking")

    def test_imu(self):
        done = live(stream_of(recording), "--wait", config=imu_config)
        lines = [tum(line) for line in estimates(done.stdout) if line["has_pose"]]
        self.assertEqual(lines, self.by_run(imu_config, recording, "--all-poses").splitlines())

    def test_imu_of_euroc_layout_with_a_time_offset(self):
        folder = self.folder / "euroc"
        options = ["--layout", "euroc", "--duration", "1", "--late", "0.02", "--seed", "3"]
        subprocess.run([program, "simulate", "--scene", "room", "--out", folder, *options], check=True,
                       capture_output=True)
        done = live(stream_of(folder), "--wait", config=imu_config)
        lines = [tum(line) for line in estimates(done.stdout) if line["has_pose"]]
        self.assertEqual(lines, self.by_run(imu_config, folder, "--all-poses").splitlines())

    def test_map(self):
        done = live(stream_of(recording), "--wait", "--map")
        self.assertEqual([tum(line) for line in estimates(done.stdout) if line["is_sound"]],
                         self.by_run(depth_config, recording, "--map").splitlines())

    def test_raw_pixels_and_calibration_of_a_file(self):
        frame = next(iter(live_client.Tum(recording).frames()))
        pixels = bytes(range(256)) * (320 * 240 // 256)
        depth = struct.pack("<H", 2000) * (320 * 240)
        stream = message(live_client.DEPTH, struct.pack("<qII", frame[0], 320, 240) + depth, 1)
        stream += message(live_client.FRAME, struct.pack("<qII", frame[0], 320, 240) + pixels, 1)
        done = live(stream + message(live_client.END), "--calibration", recording / "calibration.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(estimates(done.stdout)), 1)

    def test_sockets(self):
        expected = self.by_run(depth_config).splitlines()
        for address in "0", str(self.folder / "socket"):
            server = self.start("--wait", "--listen", address, text=True)
            note = server.stderr.readline()
            self.assertIn("waits for a sender at", note)
            where = note.split(":")[-1].strip() if address == "0" else address
            done = subprocess.run([sys.executable, client, recording, "--speed", "0", "--connect", where], check=True,
                                  capture_output=True, timeout=60)
            self.assertEqual(server.wait(timeout=30), 0)
            self.assertEqual(server.stdout.read(), "")
            self.assertEqual([tum(line) for line in estimates(done.stdout) if line["is_sound"]], expected)
        self.assertFalse((self.folder / "socket").exists())

    def test_binary(self):
        stream = stream_of(recording)
        lines = estimates(live(stream, "--wait").stdout)
        out, at, found = live(stream, "--wait", "--format", "binary").stdout, 0, []
        while at < len(out):
            magic, version, kind, encoding, length, checksum = struct.unpack("<4sBBHII", out[at : at + 16])
            payload = out[at + 16 : at + 16 + length]
            self.assertEqual((magic, version, kind, encoding, length), (b"PLBL", 1, 16, 0, 296))
            self.assertEqual(zlib.crc32(payload, zlib.crc32(out[at : at + 12])), checksum)
            found.append(struct.unpack("<2q6I32d", payload))
            at += 16 + length
        self.assertEqual(len(found), len(lines))
        for values, line in zip(found, lines):
            self.assertEqual(values[:2], (line["stamp_ns"], line["t_ns"]))
            self.assertEqual(values[4] & 1, line["has_pose"])
            self.assertEqual(list(values[8:11]), line["position"])
            self.assertEqual(list(values[11:15]), line["quaternion"])
            self.assertEqual(list(values[15:18]), line["velocity"])
            self.assertEqual(list(values[18:39]), line["covariance"])


class Behind(Live):
    def test_dropped_frames_are_told(self):
        done = live(stream_of(recording), "--queue", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        dropped = [event for event in events(done.stdout) if event["event"] == "dropped"]
        self.assertGreater(len(dropped), 0)
        total = dropped[-1]["frames_in_all"]
        self.assertEqual(sum(event["frames"] for event in dropped), total)
        self.assertEqual(len(estimates(done.stdout)) + total, 60)
        self.assertIn(b"falls behind", done.stderr)
        self.assertIn(f"{total} frames dropped".encode(), done.stderr)

    def test_without_imu_samples_frames_go_on(self):
        calibration, *_ = live_client.Tum(recording).calibrations()
        frames = [data for _, _, data in live_client.Tum(recording).frames()]
        done = live(calibration + b"".join(frames) + message(live_client.END), "--wait", config=imu_config)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(estimates(done.stdout)), 60)

    def test_interrupted(self):
        out = self.folder / "live.tum"
        process = self.start("--wait", "--trajectory", out, stdin=subprocess.PIPE)
        process.stdin.write(stream_of(recording)[: -len(message(live_client.END))])
        process.stdin.flush()
        for _ in range(60):
            process.stdout.readline()
        time.sleep(0.2)
        process.terminate()
        self.assertEqual(process.wait(timeout=30), 130)
        self.assertIn(b"interrupted", process.stderr.read())
        self.assertEqual(out.read_text(), self.by_run(depth_config))


class Page(Live):
    def test_page_shows_the_poses(self):
        self.assertEqual(live(b"", "--page", "70000").returncode, 2)
        process = self.start("--wait", "--page", "0", stdin=subprocess.PIPE)
        note = process.stderr.readline().decode()
        if "built without pages" in note:
            self.skipTest(note)
        address = note.split()[-1]
        self.assertRegex(address, r"^http://127\.0\.0\.1:\d+/$")
        self.assertEqual(self.get(address + "poses?from=0&part=0")["frames"], 0)
        stream = stream_of(recording)
        process.stdin.write(stream)
        process.stdin.close()
        lines = [json.loads(process.stdout.readline()) for _ in range(60)]
        sound = [line for line in lines if line["is_sound"]]
        for _ in range(100):
            whole = self.get(address + "poses?from=0&part=0")
            if whole["is_over"]:
                break
            time.sleep(0.1)
        self.assertTrue(whole["is_over"])
        self.assertEqual((whole["frames"], whole["health"], whole["dropped"]), (60, "tracking", 0))
        self.assertEqual(len(whole["t"]), len(sound))
        for k, axis in enumerate("xyz"):
            for value, line in zip(whole[axis], sound):
                self.assertAlmostEqual(value, line["position"][k], 5)
        part = self.get(address + f"poses?from={len(sound) - 3}&part=0")
        self.assertEqual((part["from"], part["x"]), (len(sound) - 3, whole["x"][-3:]))
        for odd in "from=1&part=7", "from=99999&part=0", "from=x", "":
            self.assertEqual(self.get(address + "poses?" + odd)["x"], whole["x"])
        with urllib.request.urlopen(address, timeout=10) as answer:
            page = answer.read().decode()
        self.assertIn(f'"title":"plumbline live: {depth_config}"', page)
        with self.assertRaises(urllib.error.HTTPError):
            urllib.request.urlopen(address + "etc/passwd", timeout=10)
        taken = live(b"", "--page", address.rstrip("/").split(":")[-1])
        self.assertIn(b"--page: port", taken.stderr)
        process.terminate()
        process.stderr.read()
        self.assertEqual(process.wait(timeout=30), 0)

    def get(self, address):
        with urllib.request.urlopen(address, timeout=10) as answer:
            return json.loads(answer.read())


def messages_of(stream):
    """(place, type) of each."""
    at = 0
    while at < len(stream):
        _, _, kind, _, length, _ = struct.unpack("<4sBBHII", stream[at : at + 16])
        yield at, kind
        at += 16 + length


def moved(similarity, p):
    """s R p + t of [s, quaternion x y z w, t]."""
    s, x, y, z, w, *t = similarity
    a, b, c = (2 * value for value in (y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]))
    turned = p[0] + w * a + y * c - z * b, p[1] + w * b + z * a - x * c, p[2] + w * c + x * b - y * a
    return [s * value + shift for value, shift in zip(turned, t)]


class Map(Live):
    """A lap of the room (13.75 s), and part of the second one: loops between both."""

    @classmethod
    def setUpClass(cls):
        cls.root = Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.loop = cls.root / "loop"
        subprocess.run([program, "simulate", "--scene", "room", "--out", cls.loop, "--duration", "20", "--size", "320",
                        "240"], check=True, capture_output=True)
        cls.stream = stream_of(cls.loop)

    def test_page_shows_the_map(self):
        process = self.start("--wait", "--map", "--page", "0", stdin=subprocess.PIPE)
        note = process.stderr.readline().decode()
        if "built without pages" in note:
            self.skipTest(note)
        address = note.split()[-1]
        frames = [at for at, kind in messages_of(self.stream) if kind == live_client.FRAME]
        sizes, lines = [], []

        def send(first, last):
            """Frames of these numbers; their estimates have come."""
            end = frames[last] if last < len(frames) else len(self.stream)
            part = self.stream[frames[first] if first else 0 : end]
            sender = threading.Thread(target=lambda: (process.stdin.write(part), process.stdin.flush()))
            sender.start()
            lines.extend(json.loads(process.stdout.readline()) for _ in range(first, last))
            sender.join()

        def look(version):
            with urllib.request.urlopen(f"{address}map?version={version}", timeout=10) as answer:
                data = answer.read()
            sizes.append(len(data))
            return json.loads(data)

        seen, sent = [], 0
        for count in 60, 160:  # the frame a second after a page has asked gives it the map
            send(sent, count)
            version = look(0)["version"]
            time.sleep(1.1)
            send(count, count + 1)
            for _ in range(100):
                now = look(version)
                if "map" in now:
                    break
                time.sleep(0.05)
            self.assertEqual(look(now["version"]), {"version": now["version"]})
            seen.append(now["map"])
            sent = count + 1
        send(sent, len(frames))
        process.stdin.close()
        for _ in range(100):
            with urllib.request.urlopen(address + "poses?from=0&part=0", timeout=10) as answer:
                poses = json.loads(answer.read())
            if poses["is_over"]:
                break
            time.sleep(0.1)
        last, before, rounding = look(0)["map"], seen[1], 2e-4
        keyframes = [len(now["keyframes"]["t"]) for now in (*seen, last)]
        self.assertEqual(keyframes, sorted(set(keyframes)))
        for axis in "txyz", ["world"]:
            self.assertEqual({len(last["keyframes"][name]) for name in axis}, {keyframes[-1]})
        self.assertEqual(seen[0]["loops"], [])
        self.assertGreater(len(last["points"]), 100)
        self.assertLessEqual(len(last["points"]), 6000)
        self.assertLess(max(sizes), 400_000)

        self.assertGreater(len(last["loops"]), 0)
        longest = []
        for now in before, last:
            times = now["keyframes"]["t"]
            longest.append(max((times[j] - times[i] for i, j in now["loops"]), default=0))
        self.assertTrue(longest[0] < 2 and longest[1] > 10, longest)
        places = {t: p for t, *p in zip(*(last["keyframes"][axis] for axis in "txyz"))}
        shifts = [math.dist(p, places[t]) for t, *p in zip(*(before["keyframes"][axis] for axis in "txyz"))]
        self.assertGreater(max(shifts), rounding)

        self.assertTrue(lines[-1]["map"]["is_in_map"])
        self.assertGreater(lines[-1]["map"]["loops"], 0)
        self.assertEqual(lines[0]["map"]["loops"], 0)
        self.assertEqual(lines[0]["map"]["quaternion"], [0, 0, 0, 1])

        # Poses with the corrections are those that `run` writes at its end.
        final = self.folder / "final.tum"
        self.by_run(depth_config, self.loop, "--map", "--trajectory-final", final)
        rows = [list(map(float, row.split())) for row in final.read_text().splitlines()]
        self.assertEqual(len(rows), len(poses["t"]))
        corrections, k = last["corrections"], 0
        for t, world, row in zip(poses["t"], poses["world"], rows):
            while k + 1 < len(corrections["t"]) and corrections["t"][k + 1] <= t:
                k += 1
            self.assertLess(math.dist(moved(corrections["S_map_world"][k], world), row[1:4]), 1e-5)
        causal = zip(poses["x"], poses["y"], poses["z"])
        self.assertGreater(max(math.dist(row[1:4], p) for row, p in zip(rows, causal)), rounding)
        process.terminate()
        process.stderr.read()
        self.assertEqual(process.wait(timeout=30), 0)

    def test_binary_map(self):
        out, at, kinds = live(self.stream, "--wait", "--map", "--format", "binary-map").stdout, 0, []
        maps = []
        while at < len(out):
            _, _, kind, _, length, _ = struct.unpack("<4sBBHII", out[at : at + 16])
            if kind == 18:
                self.assertEqual(length, 80)
                maps.append(struct.unpack("<4I8d", out[at + 16 : at + 16 + length]))
            kinds.append(kind)
            at += 16 + length
        self.assertEqual(kinds[0], 18)
        self.assertEqual(kinds.count(16), 400)
        self.assertEqual(maps[0], (1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1))
        self.assertGreater(maps[-1][1], 0)
        self.assertEqual(len(maps), len(set(maps)))

    def test_saved_and_loaded(self):
        saved, out = self.folder / "room.map", self.folder / "found.tum"
        done = live(self.stream, "--wait", "--save-map", saved)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(b"map: ", done.stderr)
        by_run = self.folder / "run.map"
        self.by_run(depth_config, self.loop, "--save-map", by_run)
        self.assertEqual(saved.read_bytes(), by_run.read_bytes())
        done = live(self.stream, "--wait", "--load-map", saved, "--localize", "--trajectory", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(saved.read_bytes(), by_run.read_bytes())
        lines = estimates(done.stdout)
        self.assertFalse(lines[0]["map"]["is_in_map"] or lines[0]["is_sound"])
        self.assertTrue(lines[-1]["map"]["is_in_map"] and lines[-1]["is_sound"])
        self.assertEqual(lines[-1]["map"]["relocalizations"], 1)
        self.assertEqual(out.read_text().splitlines(), [tum(line) for line in lines if line["is_sound"]])
        self.assertEqual(live(b"", "--localize").returncode, 2)
        odd = live(self.stream, "--load-map", self.loop / "rgb.txt")
        self.assertEqual(odd.returncode, 1)
        self.assertIn(b"rgb.txt: not a map", odd.stderr)


class Faults(Live):
    @classmethod
    def setUpClass(cls):
        cls.calibration, *_ = live_client.Tum(recording).calibrations()
        cls.frames = [data for _, _, data in live_client.Tum(recording).frames()][:2]
        cls.t_ns = next(iter(live_client.Tum(recording).frames()))[0]

    def expect(self, text, stream, *arguments, config=depth_config):
        done = live(stream, *arguments, config=config)
        self.assertEqual(done.returncode, 1, done.stderr)
        lines = done.stderr.decode().splitlines()
        errors = [line for line in lines if line.startswith("plumbline: ") and ": note: " not in line]
        self.assertEqual(len(errors), 1, lines)
        self.assertIn(text, errors[0])
        return done

    def image(self, kind, encoding=2, t_ns=None, size=(320, 240), data=b"\0"):
        return message(kind, struct.pack("<qII", self.t_ns if t_ns is None else t_ns, *size) + data, encoding)

    def test_framing(self):
        good = self.calibration + b"".join(self.frames)
        end = message(live_client.END)
        self.expect("stream: ends after 0 messages without an end message", b"")
        self.expect("stream: ends after 5 messages without an end message", good)
        self.expect("stream: has no frames", self.calibration + end)
        self.expect("stream: message 6 does not begin with PLBL", good + b"nothing of this kind")
        self.expect("stream: the header of message 6 is cut off: 7 of 16 bytes", good + end[:7])
        self.expect("stream: message 5 (frame) is cut off", good[:-5])
        self.expect("stream: message 6 is of version 2, read is version 1", good + end[:4] + b"\2" + end[5:])
        self.expect("stream: message 6: type 99 is unknown", good + message(99))
        self.expect("stream: message 6: type 16 is unknown", good + message(16))
        self.expect("stream: message 6 (frame): 67108865 bytes, at most 67108864 are read",
                    good + b"PLBL" + struct.pack("<BBHII", 1, live_client.FRAME, 1, (64 << 20) + 1, 0))
        damaged = bytearray(good)
        damaged[-1000] ^= 4
        done = self.expect("stream: message 5 (frame): damaged: its checksum is wrong", bytes(damaged) + end)
        self.assertEqual(len(estimates(done.stdout)), 1)  # the frame before it

    def test_order(self):
        self.expect("message 1 (depth): no calibration comes before it", self.frames[0])
        self.expect("a calibration comes before all samples", self.calibration + self.frames[0] + self.calibration)
        self.expect("its time stamp is not that of the depth image before it", self.calibration +
                    self.image(live_client.DEPTH, 1, 5, data=bytes(2 * 320 * 240)) + self.image(live_client.FRAME))
        self.expect("the noise of the IMU comes after", message(live_client.CALIBRATION, b"a: 1", 2))

    def test_contents(self):
        begin = self.calibration
        self.expect("stream: message 1 (calibration): not a YAML mapping", message(live_client.CALIBRATION, b"x", 1))
        self.expect("stream: message 1 (calibration):2: camera.model",
                    message(live_client.CALIBRATION, b"camera:\n  model: pinhle\n", 1))
        self.expect("encoding 9 is unknown", message(live_client.CALIBRATION, b"x: 1", 9))
        self.expect("encoding 9 is unknown", begin + self.image(live_client.FRAME, 9))
        self.expect("(imu): 57 bytes, expected a multiple of 56", begin + message(live_client.IMU, b"x" * 57))
        self.expect("(frame): 3 bytes, expected t_ns, width, height and an image",
                    begin + message(live_client.FRAME, b"abc", 1))
        self.expect("the image is 4000000000 x 240, the calibration has 320 x 240",
                    begin + self.image(live_client.FRAME, 1, size=(4_000_000_000, 240)))
        for name, kind, size in ("frame", live_client.FRAME, 76800), ("depth", live_client.DEPTH, 153600):
            self.expect(f"({name}): 5 bytes of pixels, expected {size}", begin + self.image(kind, 1, data=b"12345"))
        self.expect("impossible time stamp", begin + self.image(live_client.FRAME, 2, -(1 << 63)))
        self.expect("needs the noise of the IMU", message(
            live_client.CALIBRATION, (recording / "calibration.yaml").read_bytes().split(b"T_body")[0], 1) +
            self.frames[0], config=imu_config)

    def test_images_that_cannot_be_used_are_skipped(self):
        end = message(live_client.END)
        odd = [self.image(live_client.FRAME, data=data) for data in (b"\x89PNG and nothing else", b"?")]
        done = live(self.calibration + b"".join(odd) + self.frames[0] + self.frames[0] + end, "--wait")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([event["event"] for event in events(done.stdout)], ["skipped", "skipped", "refused"])
        self.assertIn("late sample", events(done.stdout)[-1]["text"])
        self.assertEqual(len(estimates(done.stdout)), 1)

    def test_nothing_crashes_it(self):
        stream = self.calibration + b"".join(
            data for _, _, data in list(live_client.Tum(recording).imu_samples())[:20]) + self.frames[0]
        source = random.Random(1)
        for _ in range(60):
            odd = bytearray(stream)
            for _ in range(source.randrange(1, 4)):
                odd[source.randrange(len(odd))] = source.randrange(256)
            odd = odd[: source.randrange(len(odd))]
            done = live(bytes(odd))
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(b"plumbline: stream: ", done.stderr)
        for _ in range(60):  # with checksums that are right
            payload = bytes(source.randrange(256) for _ in range(source.randrange(120)))
            odd = message(source.randrange(1, 5), payload, source.randrange(3)) + message(live_client.END)
            self.assertIn(live(self.calibration + odd).returncode, (0, 1))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
