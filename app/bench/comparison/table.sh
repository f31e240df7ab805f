#!/bin/sh
# table.sh SCENES_FOLDER: runs the peers' programs and writes their figures as Markdown.
set -eu
[ $# -eq 1 ] || { echo "usage: table.sh SCENES_FOLDER" >&2; exit 2; }
cd "$1"
bin=../bin
value() { printf '%s' "$1" | python3 -c "import json,sys; d=json.load(sys.stdin); print($2)"; }

echo '| voxelize, 4 threads | Tandem, cpu s | OpenVDB, cpu s | ratio |'
echo '|---|---|---|---|'
for run in 'bracket_actuator_fixed.stl 0.001' 'clutter_fixed.stl 0.005'; do
  set -- $run
  out=$("$bin/peer_voxelize" "$1" --voxel "$2")
  value "$out" "'| $1, $2 m | %.3g | %.3g | %.1f |' % (d['tandem']['cpu_s'], d['openvdb']['cpu_s'], d['cpu_ratio'])"
done
echo
echo '| points, 1 thread | Tandem, ns | OpenVDB, ns | ratio |'
echo '|---|---|---|---|'
for run in 'bracket_actuator 0.001' 'clutter 0.005'; do
  set -- $run
  out=$("$bin/peer_points" "$1_fixed.stl" "$1_actuator.stl" "$1_poses.csv" --voxel "$2" --spacing 0.001)
  value "$out" "'| $1, map of $2 m | %.2f | %.2f | %.1f |' % (d['tandem_ns'], d['openvdb_ns'], d['ratio'])"
done
echo
echo '| frame, 1 thread, us | Tandem (contacts) | FCL contacts | yes or no | distance | ratios |'
echo '|---|---|---|---|---|---|'
for scene in bracket_actuator clutter; do
  out=$("$bin/peer_contact" "${scene}_fixed.stl" "${scene}_actuator.stl" "${scene}_poses.csv")
  value "$out" "'\n'.join('| $scene, %s | %.1f (%.0f) | %.0f (%.0f) | %.1f | %.0f | %.1f, %.2f, %.1f |' % (k['kind'], k['frame_us'], k['frame_contacts'], k['fcl_contacts_us'], k['fcl_contacts'], k['fcl_yes_no_us'], k['fcl_distance_us'], k['contacts_ratio'], k['yes_no_ratio'], k['distance_ratio']) for k in d['kinds'])"
done
