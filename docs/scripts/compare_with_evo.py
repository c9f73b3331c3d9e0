#!/usr/bin/env python3
"""Compare `loc-sim eval` with evo on random trajectories.

    python docs/scripts/compare_with_evo.py [--cases N] [--seed S] [--command "target/release/loc-sim"]

Draws pairs of trajectories, planar and in space, with different rates, offsets, gaps, repeated
stamps and quaternions that are not of unit length; evaluates each with evo's Python interface and
with `loc-sim eval --json`, for every alignment; and demands the same number of pairs and the same
figures within 1e-6. The exit code is 1 where they differ. Without evo (`pip install evo`) there is
nothing to compare: it says so and exits with 0.
"""

import argparse
import json
import math
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy as np
    from evo import EvoException
    from evo.core import geometry, lie_algebra, metrics, sync
    from evo.tools import file_interface
except ImportError as error:
    print(f"skipped: evo is not installed ({error})")
    sys.exit(0)

TOLERANCE = 1e-6
NAMES = ["rmse", "mean", "median", "std", "min", "max", "sse"]
ALIGNMENTS = ["none", "origin", "se2"]


def stamps(rng, rate, start):
    """Stamps of one recording: jitter, gaps, repetitions [s]."""
    count = int(rng.integers(2, 200))
    times = start + np.arange(count) / rate
    if rng.random() < 0.5:
        times = times + rng.normal(0.0, 0.2 / rate, count)
    if rng.random() < 0.3:
        times = np.round(times, 2)
    if rng.random() < 0.3:
        times = np.repeat(times, rng.integers(1, 4, count))
    if rng.random() < 0.4:
        times = times[rng.random(len(times)) < 0.7]
    if len(times) == 0:
        times = np.array([start])
    return np.sort(times)


def poses(rng, times, planar, origin):
    """Poses along a smooth path with noise: rows x y z qx qy qz qw."""
    t = times - times.min()
    noise = 10.0 ** rng.uniform(-4, 0)
    position = np.column_stack([5 * np.sin(0.3 * t), 3 * np.sin(0.5 * t + 0.4), 0.7 * np.cos(0.2 * t)])
    position += rng.normal(0.0, noise, position.shape) + origin
    yaw = 0.6 * t + rng.normal(0.0, noise, len(t))
    quaternion = np.column_stack([np.zeros_like(t), np.zeros_like(t), np.sin(yaw / 2), np.cos(yaw / 2)])
    if planar:
        position[:, 2] = 0.0
    else:
        quaternion += rng.normal(0.0, 0.3, quaternion.shape)
        quaternion /= np.linalg.norm(quaternion, axis=1)[:, None]
    if rng.random() < 0.3:
        quaternion *= rng.uniform(0.2, 4.0, len(t))[:, None]
    return np.column_stack([position, quaternion])


def write(path, times, rows):
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    lines += [" ".join(repr(float(v)) for v in [t, *row]) for t, row in zip(times, rows)]
    path.write_text("\n".join(lines) + "\n")


def make_case(rng, folder):
    """Writes one pair of files; returns their paths and whether they are planar."""
    planar = bool(rng.random() < 0.5)
    start = float(rng.choice([0.0, 12.5, 1.6e9]))
    origin = rng.choice([0.0, 100.0, 5e5]) * np.array([1.0, -0.7, 0.0 if planar else 0.01])
    rates = rng.choice([1.0, 7.0, 10.0, 30.0, 100.0], 2)
    offset = float(rng.choice([0.0, 0.004, 0.01, -0.01, 0.1, 1.0]))
    paths = folder / "estimate.tum", folder / "reference.tum"
    for path, rate, begin in zip(paths, rates, [start + offset, start]):
        times = stamps(rng, rate, begin)
        write(path, times, poses(rng, times, planar, origin))
    return paths, planar


def with_evo(estimate, reference, align, planar, max_dt):
    """evo's figures, or None where it finds nothing to compare."""
    estimate = file_interface.read_tum_trajectory_file(str(estimate))
    reference = file_interface.read_tum_trajectory_file(str(reference))
    try:
        reference, estimate = sync.associate_trajectories(reference, estimate, max_diff=max_dt)
        if align == "origin":
            estimate.align_origin(reference)
        elif align == "se2" and planar:
            # evo's own alignment in space; refused for positions on a line, where ours is not.
            estimate.align(reference)
        elif align == "se2":
            xy = [path.positions_xyz[:, :2].T for path in (estimate, reference)]
            rotation, translation, _ = geometry.umeyama_alignment(*xy)
            motion = lie_algebra.se3()
            motion[:2, :2], motion[:2, 3] = rotation, translation
            estimate.transform(motion)
    except EvoException as error:
        return None, str(error)
    relation = metrics.PoseRelation
    wanted = {
        "ape": (metrics.APE, relation.translation_part),
        "ape_rot": (metrics.APE, relation.rotation_angle_deg),
        "rpe_trans": (metrics.RPE, relation.translation_part),
        "rpe_rot": (metrics.RPE, relation.rotation_angle_deg),
    }
    figures = {"pairs": estimate.num_poses}
    for name, (metric, part) in wanted.items():
        metric = metric(part)
        try:
            metric.process_data((reference, estimate))
            figures[name] = metric.get_all_statistics()
        except EvoException:
            figures[name] = None
    # Three dimensions may turn a plane over, which a motion in the plane cannot.
    upright = all(pose[2, 2] > 0.0 for pose in estimate.poses_se3)
    if align == "se2" and planar and not upright:
        return None, "turned over"
    return figures, None


def with_loc_sim(command, estimate, reference, align, max_dt):
    call = [*command, "eval", str(estimate), str(reference), "--json", "--align", align]
    done = subprocess.run([*call, "--max-dt", repr(max_dt)], capture_output=True, text=True)
    if done.returncode == 1:
        return None, done.stderr.strip()
    if done.returncode != 0:
        sys.exit(f"{shlex.join(call)}: exit code {done.returncode}: {done.stderr}")
    return json.loads(done.stdout), None


def differences(ours, theirs):
    """The figures that differ, and the largest difference of all."""
    if ours["pairs"] != theirs["pairs"]:
        return [f"pairs: {ours['pairs']}, evo {theirs['pairs']}"], math.inf
    found, largest = [], 0.0
    for block in ["ape", "ape_rot", "rpe_trans", "rpe_rot"]:
        if (ours[block] is None) != (theirs[block] is None):
            found.append(f"{block}: {ours[block]}, evo {theirs[block]}")
            continue
        unit = "deg" if block.endswith("rot") else "m"
        for name in NAMES if ours[block] else []:
            key = f"{name}_{unit}2" if name == "sse" else f"{name}_{unit}"
            mine, other = ours[block][key], float(theirs[block][name])
            # Sums of squares over long drives are large: those relative to their size.
            error = abs(mine - other) / max(1.0, abs(other))
            largest = max(largest, error)
            if not error <= TOLERANCE:
                found.append(f"{block}.{key}: {mine!r}, evo {other!r}")
    return found, largest


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--command", default="cargo run --quiet --release -p loc-sim --")
    arguments = parser.parse_args()
    command = shlex.split(arguments.command)
    rng = np.random.default_rng(arguments.seed)
    compared, refused, failures, largest = 0, 0, 0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        for case in range(arguments.cases):
            (estimate, reference), planar = make_case(rng, Path(folder))
            max_dt = float(rng.choice([0.01, 0.01, 0.0, 0.05, 1.0]))
            for align in ALIGNMENTS:
                theirs, why = with_evo(estimate, reference, align, planar, max_dt)
                ours, our_why = with_loc_sim(command, estimate, reference, align, max_dt)
                if theirs is None and (ours is None or align == "se2"):
                    refused += 1
                    continue
                if theirs is None or ours is None:
                    found = [f"refused by one only: {our_why or why}"]
                else:
                    found, error = differences(ours, theirs)
                    largest = max(largest, error)
                    compared += 1
                failures += bool(found)
                for line in found:
                    print(f"case {case} ({'planar' if planar else 'space'}, {align}, {max_dt} s): {line}")
    print(f"{compared} comparisons, {refused} without figures, {failures} differ; "
          f"largest difference {largest:.1e}")
    return 1 if failures or compared == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
