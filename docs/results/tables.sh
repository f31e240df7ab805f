#!/bin/sh
# Makes the tables of docs/results from their data: each NNNN-name.csv gives NNNN-name.md.
#
#   docs/results/tables.sh                  writes all tables
#   docs/results/tables.sh 0050-*.csv       writes the tables of these files
#   docs/results/tables.sh --check [FILE]…  writes nothing; exits with 1 if a table differs from its data
#
# A csv file follows RFC 4180, without line breaks in a field. Its header is
#
#   quantity,setting,value,unit,asked,machine,command
#
# A row holds one value: a number (with <, <=, > or >= before it where only a bound is known), one word, or
# 16 hexadecimal digits. `asked` is the bar, or empty. `machine` is a name of machines.csv. Rows of one machine
# and command form one table, in the order of the file.
set -eu
export LC_ALL=C

fail() {
  echo "tables.sh: $1" >&2
  exit 1
}

check=no
if [ "${1-}" = --check ]; then
  check=yes
  shift
fi
folder=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
here=$(pwd)
cd -- "$folder"
new=$(mktemp)
trap 'rm -f "$new"' EXIT

# Prints the table of the csv file $1, whose decision has the title $2.
make_table() {
  awk -v file="$1" -v title="$2" '
    # Splits a line of csv into field[1..n] and returns n, or 0 where the quotes are wrong.
    function split_csv(line, field,    n, cell, end) {
      n = 0
      for (;;) {
        cell = ""
        if (substr(line, 1, 1) == "\"") {
          line = substr(line, 2)
          for (;;) {
            end = index(line, "\"")
            if (end == 0) return 0
            cell = cell substr(line, 1, end - 1)
            line = substr(line, end + 1)
            if (substr(line, 1, 1) != "\"") break
            cell = cell "\""
            line = substr(line, 2)
          }
          if (line != "" && substr(line, 1, 1) != ",") return 0
          end = (line == "") ? 0 : 1
        } else {
          end = index(line, ",")
          cell = (end == 0) ? line : substr(line, 1, end - 1)
          if (index(cell, "\"") > 0) return 0
        }
        field[++n] = cell
        if (end == 0) return n
        line = substr(line, end + 1)
      }
    }
    function refuse(what) {
      print "tables.sh: " FILENAME ", line " FNR ": " what | "cat >&2"
      failed = 1
      exit 1
    }
    function is_value(text) {
      return text ~ /^(<|<=|>|>=)?[-+]?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?$/ ||
             text ~ /^[A-Za-z][A-Za-z0-9_-]*$/ || (length(text) == 16 && text ~ /^[0-9a-f]+$/)
    }
    function cell_of(text) {
      gsub(/\|/, "\\|", text)
      gsub(/</, "\\<", text)
      gsub(/\*/, "\\*", text)
      return text
    }
    # A command line stands as code; a sentence that names a method stands as text.
    function command_of(text) {
      if (text ~ /^(\.\/)?[A-Za-z0-9_.\/-]+$/ || text ~ /^((\.\/)?tandem|[A-Z_]+=[^ ]+|ctest|cmake|[a-z_]*_test|peer_[a-z]+|(build|tests|bin)\/[^ ]+) /)
        return "`" text "`"
      return cell_of(text)
    }
    { sub(/\r$/, "") }
    FNR == 1 { file_number++ }
    file_number == 1 {
      if (split_csv($0, field) != 6) refuse("a machine has six fields; quote a field that has a comma")
      if (FNR > 1) {
        machine[field[1]] = field[2]
        if (field[3] != "") machine[field[1]] = machine[field[1]] ", " field[3] " cores"
        if (field[4] != "") machine[field[1]] = machine[field[1]] ", " field[4]
        if (field[5] != "") machine[field[1]] = machine[field[1]] ", " field[5]
        machine[field[1]] = machine[field[1]] ". " field[6]
        if (field[2] == field[1]) machine[field[1]] = field[6]
        machine_name[++machines] = field[1]
      }
      next
    }
    FNR == 1 {
      if ($0 != "quantity,setting,value,unit,asked,machine,command")
        refuse("the header must be quantity,setting,value,unit,asked,machine,command")
      next
    }
    $0 == "" { next }
    {
      if (split_csv($0, field) != 7) refuse("a row has seven fields; quote a field that has a comma")
      if (field[1] == "") refuse("the quantity is empty")
      if (!is_value(field[3])) refuse("\"" field[3] "\" is not one value; see the head of tables.sh")
      if (!(field[6] in machine)) refuse("machines.csv has no machine \"" field[6] "\"")
      if (field[7] == "") refuse("the command is empty")
      key = field[6] SUBSEP field[7]
      if (!(key in group)) {
        group[key] = ++groups
        group_machine[groups] = field[6]
        group_command[groups] = field[7]
      }
      g = group[key]
      used[field[6]] = 1
      r = ++rows[g]
      for (c = 1; c <= 5; c++) {
        text[g, r, c] = cell_of(field[c])
        if (field[c] != "") filled[g, c] = 1
      }
    }
    END {
      if (failed) exit 1
      split("quantity setting value unit asked", name, " ")
      number = substr(file, 1, 4)
      stem = substr(file, 1, length(file) - 4)
      print "# " number ": " title ": figures\n"
      print "`tables.sh` makes this file from [" file "](" file "): edit the data, not this file. The reasons are in"
      print "[decision " number "](../decisions/" stem ".md).\n"
      for (m = 1; m <= machines; m++)
        if (machine_name[m] in used) print "- Machine `" machine_name[m] "`: " machine[machine_name[m]]
      for (g = 1; g <= groups; g++) {
        print "\nCommand: " command_of(group_command[g]) ". Machine: `" group_machine[g] "`.\n"
        head = "|"; rule = "|"
        for (c = 1; c <= 5; c++)
          if ((g, c) in filled) { head = head " " name[c] " |"; rule = rule (c == 3 ? "---:|" : "---|") }
        print head; print rule
        for (r = 1; r <= rows[g]; r++) {
          line = "|"
          for (c = 1; c <= 5; c++) if ((g, c) in filled) line = line " " text[g, r, c] " |"
          gsub(/\|  \|/, "| |", line); gsub(/\|  \|/, "| |", line)
          print line
        }
      }
    }' machines.csv "$1"
}

[ $# -gt 0 ] || set -- [0-9][0-9][0-9][0-9]-*.csv
differs=no
for file in "$@"; do
  name=$(basename -- "$file")
  [ -f "$name" ] || fail "there is no docs/results/$name (from $here)"
  stem=${name%.csv}
  decision=../decisions/$stem.md
  [ -f "$decision" ] || fail "docs/results/$name has no decision docs/decisions/$stem.md: give both the same name"
  title=$(sed -n '1s/^# [0-9][0-9][0-9][0-9]:\{0,1\} //p' "$decision")
  [ -n "$title" ] || fail "docs/decisions/$stem.md must begin with '# NNNN: title'"
  make_table "$name" "$title" >"$new" || exit 1
  if cmp -s "$new" "$stem.md"; then continue; fi
  if [ "$check" = yes ]; then
    echo "docs/results/$stem.md differs from docs/results/$name: run docs/results/tables.sh" >&2
    differs=yes
  else
    cat "$new" >"$stem.md"
  fi
done
[ "$differs" = no ] || exit 1
