#!/usr/bin/env python3
"""Judges what `tandem bench fidelity --json` printed by the bars of docs/results/0041 and 0042: fidelity_bars.py FILE

It prints a line for each figure. A figure that was not measured, because the third-party models are missing, is named and not
judged. Times are judged by their ratio to a time of the same run. Exit code: 1 if a bar is missed or nothing was judged.
"""
import json
import sys

# figure, relation, bar
BARS = [
    ("first_force_gap_voxels.min", ">", 0),
    ("first_force_gap_voxels.mean", "<=", 0.45),
    ("first_force_gap_voxels.max", "<=", 0.6),
    ("direction_error_deg.max", "<=", 0.1),
    ("sliding_ripple_max", "<=", 0.01),
    ("holds.moving", "<=", 0),
    ("holds.largest_force_step_N", "<=", 0.2),
    ("sheets.crossings", "<=", 0),
    ("clearance.error_voxels_max", "<=", 0.05),
    ("clearance.outer_error_voxels_max", "<=", 0.5),
    ("clearance.force_step_N", "<=", 0.088),
    ("nut.turned_deg", ">=", 359.9),
    ("nut.helix_error_mm", "<=", 0.08),
    ("nut.axial_blocked", ">=", 1),
    ("nut.largest_force_step_N", "<=", 0.2),
    ("nut_tight.turned_deg", ">=", 359.9),
    ("pegs.inserted_share", ">=", 1),
    ("pegs.buzz", "<=", 0.04),
    ("wrench_error_N", "<=", 0.5),
    ("dropped_frames", "<=", 0),
]
# a time, a time of the same run, and how many times as long it may take; the ratio of the bars that 0041 asks for
RATIOS = [("ball_015.frame_cpu_p99_us", "ball.frame_cpu_p99_us", 600 / 150)]


def figure_of(report, path):
    value = report
    for key in path.split("."):
        value = value.get(key) if isinstance(value, dict) else None
    return value


def main():
    with open(sys.argv[1], encoding="utf-8") as stream:
        report = json.load(stream)
    judged = missed = 0
    lines = [(path, figure_of(report, path), relation, bar) for path, relation, bar in BARS]
    for path, beside, bar in RATIOS:
        time, other = figure_of(report, path), figure_of(report, beside)
        lines.append((f"{path} / {beside}", time / other if time is not None and other else None, "<=", bar))
    for path, value, relation, bar in lines:
        if value is None:
            print(f"not measured: {path}")
            continue
        kept = {">": value > bar, ">=": value >= bar, "<=": value <= bar}[relation]
        judged += 1
        missed += not kept
        print(f"{'kept' if kept else 'MISSED'}: {path} = {float(value):.4g}, bar {relation} {bar:.4g}")
    print(f"{judged - missed} of {judged} bars were found kept")
    return 1 if missed or not judged else 0


if __name__ == "__main__":
    sys.exit(main())
