#!/bin/sh
# Runs every cell of every sweep in scenes/stability, and a thousand drawn cases, and prints a line for each: its exit
# code, its digest, and the rows that fail. usage: presets.sh TANDEM [JOBS]; ends with the number of those that fail.
set -u
tandem=$1
jobs=${2:-2}
presets=$(dirname "$0")/../../scenes/stability
failed=0
for sweep in paper default acceptance map offset networks; do
  out=$("$tandem" stability sweep "$presets/$sweep.json" --jobs "$jobs")
  code=$?
  [ "$code" -eq 0 ] || failed=$((failed + 1))
  echo "$sweep.json: exit $code"
  echo "$out" | grep -E '^FAIL|, digest |^  cell '
done
out=$("$tandem" stability random --seeds 1000 --jobs "$jobs")
code=$?
[ "$code" -eq 0 ] || failed=$((failed + 1))
echo "random: exit $code"
echo "$out"
exit "$failed"
