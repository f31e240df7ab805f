#!/bin/sh
# Runs every cell of every sweep in scenes/stability and prints a line for each: its exit code, its digest, and the
# rows that fail. usage: presets.sh TANDEM [JOBS]; ends with the number of sweeps with a row that fails.
set -u
tandem=$1
jobs=${2:-2}
presets=$(dirname "$0")/../../scenes/stability
failed=0
for sweep in paper default acceptance map; do
  out=$("$tandem" stability sweep "$presets/$sweep.json" --jobs "$jobs")
  code=$?
  [ "$code" -eq 0 ] || failed=$((failed + 1))
  echo "$sweep.json: exit $code"
  echo "$out" | grep -E '^FAIL|, digest |^  cell '
done
exit "$failed"
