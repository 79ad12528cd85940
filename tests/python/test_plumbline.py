"""The Python module against the program: test_plumbline.py PROGRAM RECORDING (three seconds of the simulated room, 320 x 240)."""

import json
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np
from PIL import Image

import plumbline

program, recording = sys.argv[1], Path(sys.argv[2])
depth_config, imu_config = "rgbd/points/window", "mono-imu/points/window"


def rows(name):
    lines = (recording / name).read_text().splitlines()
    return [line.split() for line in lines if not line.startswith("#")]


def nanoseconds(seconds):
    whole, fraction = seconds.split(".")
    return int(whole) * 1_000_000_000 + int(fraction.ljust(9, "0"))


def frames():
    depth = {t: file for t, file in rows("depth.txt")}
    for t, file in rows("rgb.txt"):
        yield nanoseconds(t), np.asarray(Image.open(recording / file)), read_depth(depth[t])


def read_depth(file):
    return np.asarray(Image.open(recording / file)).astype(np.uint16)


def imu_samples():
    table = [[float(value) for value in row[1:]] for row in rows("imu.csv")]
    return np.array([nanoseconds(row[0]) for row in rows("imu.csv")]), np.array(table)


def by_program(config, *arguments):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.tum"
        subprocess.run(
            [program, "run", "--config", config, "--dataset", recording, "--trajectory", out, *arguments],
            check=True, capture_output=True)
        return out.read_bytes()


def written(trajectory):
    with tempfile.TemporaryDirectory() as folder:
        trajectory.write(Path(folder) / "out.tum")
        return (Path(folder) / "out.tum").read_bytes()


def trajectory_of(states):
    sound = [state for state in states if state.is_sound]
    return plumbline.Trajectory([s.t_ns for s in sound], [s.position for s in sound], [s.quaternion for s in sound])


def fed(estimator):
    return [estimator.add_frame(t, gray, depth) for t, gray, depth in frames()]


def new_estimator(config=depth_config, **options):
    return plumbline.Estimator(config, recording / "calibration.yaml", **options)


class Names(unittest.TestCase):
    def test_configurations(self):
        self.assertIn(depth_config, plumbline.configurations())
        self.assertIn(imu_config, plumbline.configurations())

    def test_stubs_name_what_there_is(self):
        stubs = (Path(plumbline.__file__).parent / "__init__.pyi").read_text()
        self.assertTrue((Path(plumbline.__file__).parent / "py.typed").exists())
        for name in plumbline.__all__:
            self.assertIn(f" {name}" if name != "__version__" else name, stubs)
            thing = getattr(plumbline, name)
            if isinstance(thing, type):
                for member in vars(thing):
                    if not member.startswith("_"):
                        self.assertIn(f"def {member}(", stubs)


class Runs(unittest.TestCase):
    def test_run_as_the_program(self):
        for config in depth_config, imu_config:
            arguments = ["--all-poses"] if config == imu_config else []
            run = plumbline.run(recording, config, all_poses=bool(arguments))
            self.assertEqual(run.config, config)
            self.assertGreater(len(run.trajectory), 5)
            self.assertEqual(written(run.trajectory), by_program(config, *arguments))
            self.assertEqual(run.landmarks.shape[1], 3)
            self.assertIn("frames", run.summary)

    def test_run_with_map_as_the_program(self):
        self.assertEqual(written(plumbline.run(recording, depth_config, map=True).trajectory),
                         by_program(depth_config, "--map"))

    def test_frames_one_by_one_as_the_program(self):
        estimator = new_estimator()
        states = fed(estimator)
        self.assertEqual(written(trajectory_of(states)), by_program(depth_config))
        self.assertEqual(estimator.health, "tracking")
        self.assertEqual(estimator.state.t_ns, states[-1].t_ns)
        self.assertGreater(estimator.landmarks.shape[0], 50)
        self.assertEqual(estimator.covariance.shape, (6, 6))
        np.testing.assert_array_equal(estimator.covariance, estimator.state.covariance)
        self.assertTrue((np.linalg.eigvalsh(estimator.covariance) > 0).all())
        np.testing.assert_allclose(states[-1].T_world_body[:3, 3], states[-1].position, atol=1e-12)

    def test_imu_sample_by_sample_and_as_arrays(self):
        times, samples = imu_samples()
        poses = []
        for as_arrays in False, True:
            estimator, states, at = new_estimator(imu_config), [], 0
            for t, gray, _ in frames():
                end = min(int(np.searchsorted(times, t)) + 1, len(times))  # the first one at or after the frame, too
                if as_arrays and end > at:
                    estimator.add_imu(times[at:end], samples[at:end, :3], samples[at:end, 3:])
                for i in range(at, end if not as_arrays else at):
                    estimator.add_imu(int(times[i]), samples[i, :3], list(samples[i, 3:]))
                at = max(at, end)
                states.append(estimator.add_frame(t, gray))
            with_pose = [s for s in states if s.has_pose]
            poses.append(written(plumbline.Trajectory(
                [s.t_ns for s in with_pose], [s.position for s in with_pose], [s.quaternion for s in with_pose])))
        self.assertEqual(poses[0], by_program(imu_config, "--all-poses"))
        self.assertEqual(poses[1], poses[0])

    def test_evaluate_as_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out.tum"
            trajectory = plumbline.run(recording, depth_config).trajectory
            trajectory.write(out)
            truth = recording / "groundtruth.txt"
            for align in "se3", "sim3", "posyaw", "none":
                text = subprocess.run(
                    [program, "evaluate", "--reference", truth, "--estimate", out, "--align", align, "--json",
                     "--rpe-delta", "5", "--rpe-unit", "frames"], check=True, capture_output=True).stdout
                expected = json.loads(text)
                figures = plumbline.evaluate(truth, out, align=align, rpe_delta=5, rpe_unit="frames")
                for key, value in figures.items():
                    self.assertEqual(value, expected[key], (align, key))
                self.assertEqual(set(expected) - set(figures), {"reference", "estimate", "alignment"})
            of_arrays = plumbline.evaluate(plumbline.Trajectory.read(truth), plumbline.Trajectory.read(out))
            self.assertEqual(of_arrays, plumbline.evaluate(truth, out))


class Views(unittest.TestCase):
    def test_a_view_is_not_copied(self):
        t, gray, depth = next(frames())
        padded = np.zeros((gray.shape[0] + 8, gray.shape[1] + 100), np.uint8)
        view = padded[4:-4, 30:-70]
        view[:] = gray
        self.assertEqual(plumbline._plumbline._pixels_at(view), view.__array_interface__["data"][0])
        wide = np.zeros((depth.shape[0], depth.shape[1] + 2), np.uint16)
        wide[:, 1:-1] = depth
        read_only = wide[:, 1:-1]
        read_only.flags.writeable = False
        for state in new_estimator().add_frame(t, view, read_only), new_estimator().add_frame(t, gray, depth):
            self.assertEqual(state.health, "tracking")

    def test_padded_rows_give_the_same_poses(self):
        estimator, states = new_estimator(), []
        for t, gray, depth in frames():
            wide = np.full((gray.shape[0], gray.shape[1] + 13), 255, np.uint8)
            wide[:, 5:-8] = gray
            states.append(estimator.add_frame(t, wide[:, 5:-8], depth))
        self.assertEqual(written(trajectory_of(states)), by_program(depth_config))


class Threads(unittest.TestCase):
    def test_two_estimators_in_two_threads(self):
        alone = written(trajectory_of(fed(new_estimator())))
        results = [None, None]

        def work(i):
            results[i] = written(trajectory_of(fed(new_estimator())))

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(results, [alone, alone])

    def test_one_estimator_in_two_threads(self):
        estimator, given, refused = new_estimator(), list(frames()), []

        def work():
            for t, gray, depth in given:
                try:
                    estimator.add_frame(t, gray, depth)
                except plumbline.Refused as error:  # the other one was first
                    refused.append(str(error))

        threads = [threading.Thread(target=work) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len([text for text in refused if "late sample" in text]), len(refused))
        self.assertGreaterEqual(len(refused), len(given))
        self.assertEqual(estimator.health, "tracking")

    def test_others_work_during_a_run(self):
        counts, is_over = [0], threading.Event()

        def count():
            while not is_over.wait(0.002):
                counts[0] += 1

        thread = threading.Thread(target=count)
        thread.start()
        before = counts[0]
        plumbline.run(recording, depth_config)
        during = counts[0] - before
        is_over.set()
        thread.join()
        self.assertGreater(during, 10)  # 0 or 1 of a run that keeps the lock


class Errors(unittest.TestCase):
    def expect(self, kind, text, function, *arguments, **options):
        with self.assertRaises(kind) as caught:
            function(*arguments, **options)
        self.assertIn(text, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def test_names(self):
        self.expect(ValueError, 'configuration "rgbd/pionts/window" is unknown, did you mean "rgbd/points/window"?',
                    new_estimator, "rgbd/pionts/window")
        self.expect(ValueError, "is unknown", plumbline.run, recording, "nothing")
        self.expect(ValueError, "the alignment is none, se3, sim3 or posyaw, not x", plumbline.evaluate,
                    recording / "groundtruth.txt", recording / "groundtruth.txt", align="x")

    def test_files_as_the_program(self):
        self.expect(plumbline.Error, "no such file", plumbline.Estimator, depth_config, recording / "none.yaml")
        self.expect(plumbline.Error, "none", plumbline.run, recording / "none")
        failed = subprocess.run([program, "run", "--config", depth_config, "--dataset", recording / "none"],
                                capture_output=True, text=True)
        with self.assertRaises(plumbline.Error) as caught:
            plumbline.run(recording / "none", depth_config)
        self.assertEqual("plumbline: " + str(caught.exception), failed.stderr.strip())
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "calibration.yaml"
            lines = (recording / "calibration.yaml").read_text().replace("model: pinhole", "model: pinhle")
            file.write_text(lines)
            self.expect(plumbline.Error, f"{file}:2: ", plumbline.Estimator, depth_config, file)
            file.write_text(lines.replace("pinhle", "pinhole").split("depth:")[0])
            self.expect(plumbline.Error, "depth scale", plumbline.Estimator, depth_config, file)
            self.expect(plumbline.Error, "noise of the IMU", plumbline.Estimator, imu_config, file)

    def test_arrays(self):
        t, gray, depth = next(frames())
        estimator = new_estimator()
        add = estimator.add_frame
        self.expect(TypeError, "gray is of float64, expected uint8", add, t, gray.astype(float), depth)
        self.expect(TypeError, "depth is of float32, expected uint16", add, t, gray, depth.astype(np.float32))
        self.expect(ValueError, "gray is 240 x 320 x 3, expected height x width", add, t, np.stack([gray] * 3, 2))
        self.expect(ValueError, "gray has strides of", add, t, np.asfortranarray(gray), depth)
        self.expect(ValueError, "gray has strides of", add, t, gray[::-1], depth)
        self.expect(ValueError, "gray has strides of", add, t, np.repeat(gray, 2, 1)[:, ::2], depth)
        self.expect(ValueError, "depth has strides of", add, t, gray, np.repeat(depth, 2, 1)[:, ::2])
        self.expect(plumbline.Refused, "wrong image size: gray is 160 x 120, the calibration has 320 x 240", add, t,
                    np.zeros((120, 160), np.uint8), depth)
        self.expect(plumbline.Refused, "wrong image size: depth is 318 x 240", add, t, gray, depth[:, 1:-1])
        self.assertIsNone(estimator.state)
        self.assertEqual(estimator.health, "initializing")
        add(t, gray, depth)
        self.expect(plumbline.Refused, "late sample: the frame at", add, t, gray, depth)
        self.assertEqual(estimator.health, "tracking")

    def test_imu(self):
        self.expect(plumbline.Refused, "is one without an IMU", new_estimator().add_imu, 1, [0, 0, 0], [0, 0, 9.8])
        estimator = new_estimator(imu_config)
        add = estimator.add_imu
        add(10_000_000, [0, 0, 0], [0, 0, 9.8])
        self.expect(plumbline.Refused, "not finite: the IMU sample at 20000000 ns", add, 20_000_000, [0, 0, 0],
                    [0, 0, float("nan")])
        self.expect(plumbline.Refused, "the first of 2 that are not used", add, [10_000_000] * 2, np.zeros((2, 3)),
                    np.zeros((2, 3)))
        self.expect(ValueError, "gyro is 2 x 4, expected 2 x 3", add, [1, 2], np.zeros((2, 4)), np.zeros((2, 3)))
        self.expect(ValueError, "accel is 3, expected 2 x 3", add, [1, 2], np.zeros((2, 3)), np.zeros(3))
        self.expect(TypeError, "t_ns must be a whole number of nanoseconds", add, 1.5, [0, 0, 0], [0, 0, 9.8])
        _, gray, depth = next(frames())
        self.expect(plumbline.Refused, "is one without depth", estimator.add_frame, 20_000_000, gray, depth)

    def test_trajectories(self):
        self.expect(ValueError, "row 1: the time stamp", plumbline.Trajectory, [5, 5], np.zeros((2, 3)),
                    [[0, 0, 0, 1]] * 2)
        self.expect(ValueError, "row 0: the quaternion", plumbline.Trajectory, [5], np.zeros((1, 3)), [[0, 0, 0, 2]])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
