#!/usr/bin/env python3
"""Answers of `plumbline doctor` and `plumbline run` to inputs as they come from the field, as results of kind `field`.

    measure_field.py PROGRAM RECORDINGS FIELD WORK OUT

FIELD is the folder with alter.py, which makes recordings of RECORDINGS faulty, and with calibrations. WORK keeps what
is made; OUT is the JSON file to write."""
import json
import os
import re
import subprocess
import sys

program, recordings, field, work, out = (os.path.realpath(each) for each in sys.argv[1:6])
flight = ["flight"]  # the recording that most others are made from


def calibrated(file):
    return [*flight, "--calibration", "field/" + file]


# Recordings of `plumbline simulate` with a fault: name, what it is, options.
SIMULATED = [
    ("sim_good", "simulated, without a fault", []),
    ("sim_late", "simulated: time stamps of the images are 0.4 s late", ["--late", "0.4"]),
    ("sim_turn", "simulated: the stated camera is turned by 90 degrees", ["--extrinsics-turn", "0", "0", "90"]),
    ("sim_tilt", "simulated: the stated camera is turned by 6 degrees", ["--extrinsics-turn", "6", "0", "0"]),
    ("sim_sign", "simulated: accelerometer with the reversed sign", ["--accel-sign"]),
    ("sim_depth_scale", "simulated: depth scale stated as 5000, true: 1000", ["--stated-depth-scale", "5000"]),
    ("sim_bursts", "simulated: IMU samples in bursts of eight", ["--bursts", "8"]),
    ("sim_held", "simulated: each value of the accelerometer in three rows", ["--held-accel", "3"]),
    ("sim_noise", "simulated: four times the stated noise", ["--noise-factor", "4"]),
    ("sim_quiet", "simulated: a tenth of the stated noise", ["--noise-factor", "0.1"]),
    ("sim_vibration", "simulated: vibration of 8 m/s^2 at 63 Hz", ["--vibration", "8", "63"]),
    ("sim_saturated", "simulated: accelerometer saturated at 10 m/s^2", ["--accel-range", "10"]),
    ("sim_bonnet", "simulated: the lower quarter of the image is a bonnet", ["--bonnet", "0.25"]),
    ("sim_drop", "simulated: three of ten images are missing", ["--drop", "0.3"]),
]


# Name, what it is, made by (`alter`, `simulate` or nothing), words on the command lines.
INPUTS = [
    ("flight", "an unaltered recording of EuRoC, to compare with", None, flight),
    ("kalibr_camchain", "Kalibr camchain.yaml with imu.yaml beside it, a depth camera with IMU", "simulate",
     ["depth_camera", "--calibration", "field/kalibr_drops_imu/camchain.yaml"]),
    ("kalibr_imu0", "the same with imu0: in camchain.yaml, and the depth scale given", "simulate",
     ["depth_camera", "--calibration", "field/kalibr_drops_imu/camchain_with_imu0.yaml", "--depth-scale", "1000"]),
    ("tumvi", "layout and calibration of TUM-VI: 16-bit fisheye images, dso/, mocap0/", "alter", ["tumvi"]),
    ("accel_hold62", "accelerometer of 62.5 Hz repeated in rows of 200 Hz", "alter", ["accel_hold62"]),
    ("imu62", "all of the IMU at 62.5 Hz", "alter", ["imu62"]),
    ("hood25", "the lower quarter of the image is a vehicle bonnet", "alter", ["hood25"]),
    ("late110", "time stamps of the images are 110 ms late", "alter", ["late110"]),
    ("depth_scale", "depth scale stated as 5000, true: 1000", None, ["lowtex", "--depth-scale", "5000"]),
    ("mount_inverse", "T_imu_cam given as T_cam_imu", None, calibrated("wrong_mount/inv.yaml")),
    ("mount_90", "the stated camera is turned by 90 degrees", None, calibrated("wrong_mount/90.yaml")),
    ("accel_sign", "accelerometer with the reversed sign", "alter", ["accel_sign"]),
    ("imu_repeated", "rows of the IMU that come twice", "alter", ["imu_repeated"]),
    ("imu_bursts", "IMU samples in bursts of ten with stamps of arrival", "alter", ["imu_bursts"]),
    ("head_without_hash", "header lines without #", "alter", ["head_without_hash"]),
    ("image_missing", "one image is missing", "alter", ["image_missing"]),
    ("gray12", "12-bit images in 16 bits", "alter", ["gray12"]),
    ("depth_float", "depth as 32-bit float TIFF in meters", "alter", ["depth_float"]),
    ("openvins", "calibration files of OpenVINS", None, calibrated("calibrations/openvins_imucam_chain.yaml")),
    ("orb_slam3", "calibration file of ORB-SLAM3", None, calibrated("calibrations/orb3.yaml")),
    ("vins_fusion", "calibration file of a camera of VINS-Fusion", None,
     calibrated("calibrations/vins_fusion_cam0.yaml")),
    ("noise_of_vins", "stated noise densities are those of another program", None,
     calibrated("stated_wrong/noise_of_vins.yaml")),
    ("lever_in_mm", "stated lever arm in millimeters", None, calibrated("stated_wrong/lever_in_mm.yaml")),
]


def make(name, how):
    folder = os.path.join(work, "depth_camera" if how == "simulate" else name)
    if how is None or os.path.exists(folder):
        return
    if how == "simulate":
        command = [program, "simulate", "--size", "848", "480", "--duration", "6", "--out", folder]
    else:
        command = ["/usr/bin/python3", os.path.join(field, "alter.py"), name, folder, recordings]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def simulate(name, options):
    folder = os.path.join(work, name)
    if not os.path.exists(folder):
        subprocess.run([program, "simulate", "--duration", "14", "--stop", "4", "9", "--size", "320", "256", "--out", folder, *options],
                       check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def called(*words):
    done = subprocess.run([program, *words], cwd=work, capture_output=True, text=True, errors="replace")
    return done.returncode, done.stdout.splitlines(), done.stderr.splitlines()


def doctor(words):
    """The worst findings."""
    status, lines, errors = called("doctor", *words)
    found = [re.sub(" +", " ", line) for line in lines]
    for level in ("ERROR", "WARN"):
        worst = [line for line in found if line.startswith(level)]
        if worst:
            return {"status": status, "lines": worst[:3]}
    if found:
        return {"status": status, "lines": [f"nothing wrong in {len(found)} checks"]}
    return {"status": status, "lines": errors[-1:]}


def run(words):
    """What went wrong, and what is said of the input; else the summary."""
    status, lines, errors = called("run", *words)
    said = [line.removeprefix("plumbline: ") for line in errors if line.startswith("plumbline: ")]
    chosen = [line.split(", recommended")[0] for line in lines if line.startswith("configuration: ")]
    summary = [line for line in lines if re.match(r"\d+ frames", line)]
    return {"status": status, "lines": [*chosen, *said, *summary]}


def link(target, name):
    path = os.path.join(work, name)
    if os.path.islink(path):
        os.unlink(path)
    os.symlink(target, path)


os.makedirs(work, exist_ok=True)
link(os.path.join(recordings, "euroc_mh01_flight"), "flight")
link(os.path.join(recordings, "rendered_lowtex_rgbd"), "lowtex")
link(field, "field")
# Date, commit and machine are those of any results.
subprocess.run([program, "list", "--memory", "--json", out], check=True, stdout=subprocess.DEVNULL)
with open(out) as file:
    result = {key: value for key, value in json.load(file).items()
              if key in ("format", "version", "date", "commit", "machine")}
result |= {"kind": "field", "command": None, "inputs": []}
for name, what, how, words in INPUTS:
    print("field:", name, file=sys.stderr)
    make(name, how)
    result["inputs"].append({"name": name, "what": what, "doctor": doctor(words), "run": run(words)})
for name, what, options in SIMULATED:
    print("field:", name, file=sys.stderr)
    simulate(name, options)
    result["inputs"].append({"name": name, "what": what, "doctor": doctor([name]), "run": run([name])})
with open(out, "w") as file:
    json.dump(result, file, indent=1)
    file.write("\n")
