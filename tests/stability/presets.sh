#!/bin/sh
# Runs every cell of every sweep in scenes/stability and prints a line for each: its exit code, its digest, and the
# rows that fail. usage: presets.sh TANDEM [JOBS]; ends with the number of sweeps with a row that fails, but for cells
# that are known and open (docs/decisions/0029-stability-lab.md). A known one that passes counts as a failure too.
set -u
tandem=$1
jobs=${2:-2}
presets=$(dirname "$0")/../../scenes/stability
failed=0
for sweep in paper default acceptance map; do
  case $sweep in
    default) known=65 ;;
    *) known= ;;
  esac
  out=$("$tandem" stability sweep "$presets/$sweep.json" --jobs "$jobs")
  code=$?
  failing=$(echo "$out" | sed -n 's/^  cell \([0-9]*\):.*/\1/p' | tr '\n' ' ' | sed 's/ $//')
  told=
  if [ "$failing" != "$known" ] || { [ -z "$known" ] && [ "$code" -ne 0 ]; }; then
    failed=$((failed + 1))
  elif [ -n "$known" ]; then
    told=", as is known of cell $known"
  fi
  echo "$sweep.json: exit $code$told"
  echo "$out" | grep -E '^FAIL|, digest |^  cell '
done
exit "$failed"
