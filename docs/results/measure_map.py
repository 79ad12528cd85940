#!/usr/bin/python3
"""What a map of keyframes gains, as results of kind `map` (docs/results/README.md).

    measure_map.py PROGRAM RECORDINGS WORK OUT [--quick] [--jobs N] [...]

Three parts: laps of simulated scenes, black images in the last lap, and recordings of RECORDINGS, each without and with
a map. WORK keeps the simulated recordings; OUT is the JSON file to write. A configuration that PROGRAM was built
without is left out."""
import argparse
import concurrent.futures
import functools
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np

LAPS = 3
CHI2_3DOF = 14.156  # 99.7 %, 3 sigma
FOUND_M = 0.05  # a place is found by a pose that is within 3 sigma and so near the truth

# Of each class of sensors.
CONFIGURATIONS = ["mono/points/window", "mono-imu/points/window", "rgbd/points+lines/window",
                  "rgbd-imu/points+lines/window", "lap-slam"]
SENSORS = {"lap-slam": "mono"}  # of names that do not begin with them
OWN_MAP = {"lap-slam"}  # configurations that never run without a map
ALIGNMENT = {"mono": "sim3", "mono-imu": "posyaw", "rgbd": "se3", "rgbd-imu": "posyaw"}
# Scene, and the only sensors that run in it (None: all).
SCENES = [("room", None), ("hall", None), ("ring", "rgbd")]
LOST_SCENE = "room"
RECORDINGS = {"tum_fr1_rpy_first12s": ["mono", "rgbd"],
              "rendered_lowtex_rgbd": ["mono", "mono-imu", "rgbd", "rgbd-imu"],
              "euroc_mh01_flight": ["mono", "mono-imu"]}


def sensors_of(configuration):
    return SENSORS.get(configuration, configuration.split("/")[0])


class Poses:
    """Times [s], positions and rotations."""

    def __init__(self, t, p, q):  # q: x y z w
        self.t, self.p, self.q = t, p, q / np.linalg.norm(q, axis=1, keepdims=True)

    def __len__(self):
        return len(self.t)

    def rotation(self, i):
        x, y, z, w = self.q[i]
        return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])

    def select(self, rows):
        return Poses(self.t[rows], self.p[rows], self.q[rows])

    def at(self, t):
        """Interpolated between samples."""
        sign = np.cumprod(np.concatenate(([1], np.sign(np.sum(self.q[1:] * self.q[:-1], axis=1)))))
        q = self.q * sign[:, None]

        def between(values):
            return np.stack([np.interp(t, self.t, column) for column in values.T], axis=1)

        return Poses(t, between(self.p), between(q))


def read_tum(file):
    rows = np.loadtxt(file, comments="#", ndmin=2)
    return Poses(rows[:, 0], rows[:, 1:4], rows[:, 4:8]) if len(rows) else None


@functools.lru_cache(maxsize=None)
def read_truth(folder, with_imu):
    """Of a simulated recording: the body with an IMU, else the camera."""
    if not with_imu:
        return read_tum(os.path.join(folder, "groundtruth.txt"))
    file = os.path.join(folder, "groundtruth_body.csv")
    ns = np.loadtxt(file, delimiter=",", comments="#", usecols=0, dtype=np.int64)
    rows = np.loadtxt(file, delimiter=",", comments="#", usecols=range(1, 8))
    return Poses(1e-9 * ns, rows[:, 0:3], rows[:, [4, 5, 6, 3]])


def align(p, truth, kind):
    """Scale, rotation and translation that take positions to the truth with the least squared error: a similarity
    (sim3), a rigid motion (se3), or one about the vertical (posyaw)."""
    mean_p, mean_truth = p.mean(axis=0), truth.mean(axis=0)
    a, b = p - mean_p, truth - mean_truth
    scale = 1.0
    if kind == "posyaw":
        H = a[:, :2].T @ b[:, :2]
        yaw = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
        R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    else:
        U, D, Vt = np.linalg.svd(b.T @ a)
        signs = np.array([1, 1, np.sign(np.linalg.det(U @ Vt))])
        R = U @ np.diag(signs) @ Vt
        if kind == "sim3":
            scale = float((D * signs).sum() / (a**2).sum())
    return scale, R, mean_truth - scale * R @ mean_p


def rounded(value, digits=6):
    return None if value is None or not np.isfinite(value) else round(float(value), digits)


def rmse(errors):
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else None


def errors_in_laps(poses, truth, kind, begin_s, end_s):
    """ATE of all poses and of those of each lap, after one alignment over all; scale of the alignment."""
    reference = truth.at(poses.t)
    scale, R, t = align(poses.p, reference.p, kind)
    errors = np.linalg.norm(scale * poses.p @ R.T + t - reference.p, axis=1)
    lap = np.clip(np.floor(LAPS * (poses.t - begin_s) / (end_s - begin_s)), 0, LAPS - 1)
    return rmse(errors), [rmse(errors[lap == i]) for i in range(LAPS)], scale


def end_error(poses, truth, scale):
    """Of the last position relative to the first pose."""
    reference = truth.at(poses.t)

    def seen_from_first(each, unit):
        return unit * each.rotation(0).T @ (each.p[-1] - each.p[0])

    return float(np.linalg.norm(seen_from_first(poses, scale) - seen_from_first(reference, 1)))


def frame_times(folder):
    with open(os.path.join(folder, "rgb.txt")) as file:
        return np.array([float(line.split()[0]) for line in file if not line.startswith("#")])


def run(program, recording, configuration, with_map, start_s=0.0, with_states=False):
    """Trajectories by name, states and the number of loops; None of a run without poses."""
    with tempfile.TemporaryDirectory() as folder:
        files = {name: os.path.join(folder, name) for name in ("causal", "world", "final", "loops", "states")}
        words = ["run", recording, "--config", configuration, "--start", f"{start_s:g}"]
        words += ["--map"] if with_map else []
        outputs = ["--trajectory", files["causal"], "--trajectory-world", files["world"]]
        outputs += ["--states", files["states"]] if with_states else []
        outputs += ["--trajectory-final", files["final"], "--loops", files["loops"]] if with_map else []
        done = subprocess.run([program, *words, *outputs], capture_output=True, text=True, errors="replace")
        if done.returncode != 0:
            said = done.stderr.strip().splitlines() or [f"status {done.returncode}"]
            print("map: plumbline", *words, "failed:", said[-1], file=sys.stderr)
            return None
        out = {name: read_tum(files[name]) for name in ("causal", "world", "final") if os.path.exists(files[name])}
        if with_map:
            with open(files["loops"]) as file:
                out["loops"] = sum(1 for _ in file) - 1  # beside the header
        if with_states:
            out["states"] = read_states(files["states"])
        return out if out["causal"] is not None and len(out["causal"]) > 2 else None


def read_states(file):
    """Of frames with a pose: time of the image [s], whether it is `tracking`, covariance of the position."""
    with open(file) as rows:
        names = rows.readline().strip().split(",")
        cells = [row.rstrip("\n").split(",") for row in rows]
    column = {name: i for i, name in enumerate(names)}
    cells = [row for row in cells if row[column["p_x"]] != ""]
    P = np.zeros((len(cells), 3, 3))
    for i in range(3):
        for j in range(i, 3):
            P[:, i, j] = P[:, j, i] = [float(row[column[f"covariance_{i + 3}{j + 3}"]]) for row in cells]
    return {"t": np.array([1e-9 * int(row[column["timestamp_ns"]]) for row in cells]),
            "tracking": np.array([row[column["health"]] == "tracking" for row in cells], dtype=bool), "P": P}


def lap_run(program, recording, configuration, with_map, start_s):
    out = {"start_s": start_s, "poses": 0, "ate_m": None, "lap_m": [None] * LAPS, "final_m": None, "end_m": None,
           "path_m": None, "loops": 0 if with_map else None}
    kind = ALIGNMENT[sensors_of(configuration)]
    truth = read_truth(recording, "imu" in sensors_of(configuration))
    times = frame_times(recording)
    out["frames"] = int(np.sum(times >= times[0] + start_s - 1e-3))
    done = run(program, recording, configuration, with_map, start_s)
    if done is None:
        return out
    poses = done["causal"]
    ate, laps, scale = errors_in_laps(poses, truth, kind, times[0], times[-1])
    seen = truth.at(poses.t)
    out |= {"poses": len(poses), "ate_m": rounded(ate), "lap_m": [rounded(each) for each in laps],
            "end_m": rounded(end_error(poses, truth, scale)), "loops": done.get("loops"),
            "path_m": rounded(np.linalg.norm(np.diff(seen.p, axis=0), axis=1).sum(), 3)}
    if with_map:
        out["final_m"] = rounded(errors_in_laps(done["final"], truth, kind, times[0], times[-1])[0])
    return out


def black_png(width, height):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    rows = zlib.compress(bytes((width + 1) * height), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


def size_of_png(file):
    with open(file, "rb") as image:
        return struct.unpack(">II", image.read(24)[16:24])


def blackened(recording, folder, begin_s, end_s):
    """A copy whose images are black between two times [s]; all other files are those of the recording."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for name in os.listdir(recording):
        if name != "rgb.txt":
            os.symlink(os.path.join(recording, name), os.path.join(folder, name))
    out, first = [], None
    with open(os.path.join(recording, "rgb.txt")) as file:
        for line in file:
            if not line.startswith("#"):
                stamp, image = line.split()
                first = first or (float(stamp), image)
                if begin_s <= float(stamp) < end_s:
                    line = f"{stamp} black.png\n"
            out.append(line)
    with open(os.path.join(folder, "black.png"), "wb") as file:
        file.write(black_png(*size_of_png(os.path.join(recording, first[1]))))
    with open(os.path.join(folder, "rgb.txt"), "w") as file:
        file.writelines(out)


def lost_run(program, recording, work, configuration, with_map, black_s, begin_s):
    """One run with black images from begin_s after the first frame on. The map is aligned with the truth by the poses
    before them."""
    out = {"begin_s": rounded(begin_s, 3), "frames": 0, "poses": 0, "false_frames": 0, "before_m": None, "pose_s": None,
           "within_s": None, "within_error_m": None, "within_sigma_m": None, "found_s": None, "found_error_m": None,
           "found_sigma_m": None}
    kind = ALIGNMENT[sensors_of(configuration)]
    truth = read_truth(recording, "imu" in sensors_of(configuration))
    times = frame_times(recording)
    begin, end = times[0] + begin_s, times[0] + begin_s + black_s
    out["frames"] = int(np.sum(times >= end))
    with tempfile.TemporaryDirectory(dir=work) as folder:
        dark = os.path.join(folder, "recording")
        blackened(recording, dark, begin, end)
        done = run(program, dark, configuration, with_map, with_states=True)
    if done is None:
        return out
    poses, states = done["causal"], done["states"]
    before = poses.select(poses.t < begin)
    if len(before) < 3:
        return out
    scale, R, t = align(before.p, truth.at(before.t).p, kind)
    reference = truth.at(poses.t)
    errors = scale * poses.p @ R.T + t - reference.p
    sizes = np.linalg.norm(errors, axis=1)
    out["before_m"] = rounded(rmse(sizes[poses.t < begin]))
    for i in np.flatnonzero(poses.t >= end - 1e-3):
        row = int(np.argmin(np.abs(states["t"] - poses.t[i])))
        unit = scale * unit_of_world(done, i) if kind == "sim3" else 1.0
        P = unit**2 * states["P"][row]
        error = (R @ poses.rotation(i)).T @ errors[i]  # in the body, as the covariance
        is_within = bool(error @ np.linalg.solve(P, error) <= CHI2_3DOF)
        after_s = rounded(max(0.0, poses.t[i] - end), 3)
        out["poses"] += 1
        out["false_frames"] += bool(states["tracking"][row] and not is_within)
        if out["pose_s"] is None:
            out["pose_s"] = after_s
        if is_within and out["within_s"] is None:
            out |= {"within_s": after_s, "within_error_m": rounded(sizes[i]), "within_sigma_m": rounded(sigma_of(P))}
        if is_within and sizes[i] <= FOUND_M and out["found_s"] is None:
            out |= {"found_s": after_s, "found_error_m": rounded(sizes[i]), "found_sigma_m": rounded(sigma_of(P))}
    return out


def sigma_of(P):
    return np.sqrt(np.trace(P))


def unit_of_world(done, i):
    """Of a camera alone: length in the map of a unit of the world at pose i, from the poses next to it that the same
    correction has brought to the map."""
    causal, world = done["causal"], done["world"]
    k = int(np.argmin(np.abs(world.t - causal.t[i])))
    n = min(10, len(causal) - 1 - i, len(world) - 1 - k)
    moved = np.linalg.norm(np.diff(world.p[k:k + n + 1], axis=0), axis=1)
    ratio = np.linalg.norm(np.diff(causal.p[i:i + n + 1], axis=0), axis=1) / np.maximum(moved, 1e-12)
    return float(np.median(ratio)) if n > 0 else 1.0


def with_and_without(configuration):
    return [True] if configuration in OWN_MAP else [False, True]


def grouped(pool, groups, one_run, arguments_of):
    """The runs of all groups side by side; each group is printed when it is complete."""
    tasks = [[pool.submit(one_run, *arguments) for arguments in arguments_of(group)] for group in groups]
    for group, runs in zip(groups, tasks):
        group["runs"] = [each.result() for each in runs]
        print("map:", *(f"{key}={value}" for key, value in group.items() if key != "runs"), file=sys.stderr)
    return groups


def simulate(program, work, scene, seed, size):
    """The folder of a recording, which is made unless it is there."""
    folder = os.path.join(work, f"{scene}_{seed}" + "".join(f"_{each}" for each in size))
    if not os.path.exists(folder):
        words = ["simulate", "--scene", scene, "--laps", str(LAPS), "--seed", str(seed), "--out", folder + ".new"]
        words += ["--size", *map(str, size)] if size else []
        shutil.rmtree(folder + ".new", ignore_errors=True)
        print("map: plumbline", *words[:-1], file=sys.stderr)
        subprocess.run([program, *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.rename(folder + ".new", folder)
    return folder


def measure_laps(pool, program, folders, configurations, starts):
    groups = [{"dataset": scene, "seed": seed, "laps": LAPS, "configuration": configuration, "with_map": with_map}
              for scene, only in SCENES for (each, seed) in folders if each == scene
              for configuration in configurations if only in (None, configuration.split("/")[0])
              for with_map in with_and_without(configuration)]
    return grouped(pool, groups, functools.partial(lap_run, program), lambda group: [
        (folders[group["dataset"], group["seed"]], group["configuration"], group["with_map"], 0.5 * k)
        for k in range(starts)])


def measure_lost(pool, program, folders, work, configurations, black, times):
    """Black images begin at evenly spread times of the last lap, of which at least a second and a half remain."""
    groups = [{"dataset": scene, "seed": seed, "black_s": black_s, "configuration": configuration,
               "with_map": with_map}
              for (scene, seed) in folders if scene == LOST_SCENE for black_s in black
              for configuration in configurations for with_map in with_and_without(configuration)]

    def arguments_of(group):
        folder = folders[group["dataset"], group["seed"]]
        stamps = frame_times(folder)
        length = stamps[-1] - stamps[0]
        first, last = length * (LAPS - 1) / LAPS, length - group["black_s"] - 1.5
        return [(folder, work, group["configuration"], group["with_map"], group["black_s"],
                 first + (last - first) * k / max(1, times - 1)) for k in range(times)]

    return grouped(pool, groups, functools.partial(lost_run, program), arguments_of)


def measure_recordings(program, recordings, names, configurations, repeat, jobs):
    """Of `plumbline compare`, whose runs begin one frame apart."""
    groups = []
    for name in names:
        chosen = [each for each in configurations if sensors_of(each) in RECORDINGS[name]]
        for with_map in (False, True):
            fitting = [each for each in chosen if with_map in with_and_without(each)]
            if not fitting:
                continue
            with tempfile.TemporaryDirectory() as folder:
                file = os.path.join(folder, "comparison.json")
                words = ["compare", "--config", *fitting, "--dataset", name, "--repeat", str(repeat), "--jobs",
                         str(jobs), *(["--map"] if with_map else [])]
                print("map: plumbline", *words, file=sys.stderr)
                subprocess.run([program, *words, "--json", file], cwd=recordings, check=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                with open(file) as compared:
                    runs = json.load(compared)["runs"]
            groups += [{"dataset": name, "configuration": configuration, "with_map": with_map,
                        "runs": [recorded_run(run, with_map) for run in runs if run["configuration"] == configuration]}
                       for configuration in fitting]
    return sorted(groups, key=lambda group: (names.index(group["dataset"]),
                                             configurations.index(group["configuration"]), group["with_map"]))


def recorded_run(run, with_map):
    is_ok = run["status"] == "ok"
    return {"ate_m": rounded(run["ate"]["rmse"]) if is_ok else None,
            "final_m": rounded(run["ate_final"]["rmse"]) if is_ok and run.get("ate_final") else None,
            "coverage": rounded(run["coverage"]) if is_ok else 0,
            "loops": run["map_counts"]["loops"] if is_ok and with_map else None}


def available(program):
    listed = subprocess.run([program, "list"], check=True, capture_output=True, text=True).stdout
    return [line.split()[0] for line in listed.splitlines() if line]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("program", "recordings", "work", "out"):
        parser.add_argument(name, type=os.path.realpath)
    parser.add_argument("--quick", action="store_true", help="one seed, two runs of each, no hall")
    parser.add_argument("--jobs", type=int, default=1, help="runs side by side")
    parser.add_argument("--config", nargs="+", default=CONFIGURATIONS, help="configurations")
    parser.add_argument("--scene", nargs="+", help="scenes of the laps (default: room hall ring; quick: room ring)")
    parser.add_argument("--seed", nargs="+", type=int, help="of the scenes (default: 211 212; quick: 211)")
    parser.add_argument("--size", nargs=2, type=int, default=[], help="of the simulated images [px]")
    parser.add_argument("--runs", type=int, help="of each (default: 8; quick: 2)")
    parser.add_argument("--black", nargs="*", type=float, default=[2, 6], help="durations of the black images [s]")
    parser.add_argument("--recording", nargs="*", default=list(RECORDINGS), help="of RECORDINGS")
    options = parser.parse_args()
    scenes = options.scene or [scene for scene, _ in SCENES if not (options.quick and scene == "hall")]
    command = " ".join(["docs/results/measure_map.py PROGRAM RECORDINGS WORK OUT", *sys.argv[5:]])
    seeds = options.seed or ([211] if options.quick else [211, 212])
    runs = options.runs or (2 if options.quick else 8)

    os.makedirs(options.work, exist_ok=True)
    known = available(options.program)
    configurations = [each for each in options.config if each in known]
    if not configurations:
        sys.exit("measure_map.py: the program has none of the configurations")
    # Date, commit and machine are those of any results.
    subprocess.run([options.program, "list", "--memory", "--json", options.out], check=True, stdout=subprocess.DEVNULL)
    with open(options.out) as file:
        result = {key: value for key, value in json.load(file).items()
                  if key in ("format", "version", "date", "commit", "machine")}

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        wanted = [(scene, seed) for scene in scenes for seed in seeds]
        made = pool.map(lambda each: simulate(options.program, options.work, *each, options.size), wanted)
        folders = dict(zip(wanted, made))
        result |= {"kind": "map", "command": command, "map": {
            "laps": measure_laps(pool, options.program, folders, configurations, runs),
            "lost": measure_lost(pool, options.program, folders, options.work, configurations, options.black, runs),
            "recordings": measure_recordings(options.program, options.recordings, options.recording, configurations,
                                             runs, options.jobs)}}
    with open(options.out, "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main()
