#!/bin/bash
# reference_test.sh BIN REFERENCE: every command and option that --help names is in the manual pages and in the completion,
# and the pages are sound roff. BIN holds the programs, REFERENCE what the build wrote.
set -euo pipefail
bin=$1 reference=$2
faults=0
pages=$(mktemp -d)
trap 'rm -rf "$pages"' EXIT
fault() { echo "FAULT: $*"; faults=$((faults + 1)); }

# what --help names, one a line
options_in() { sed -n 's/^  \(-[^ {]*\).*/\1/p' <<<"$1" | tr , '\n'; }
commands_in() { sed -n '/^Subcommands:/,/^[^ ]/s/^  \([a-z][a-z0-9-]*\) .*/\1/p' <<<"$1"; }

completed() { # words of a command line, the last one unfinished: what bash would offer
  local COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
  "_${1//-/_}"
  printf '%s\n' "${COMPREPLY[@]}"
}

page_of() { # command's words: its page as plain text
  local name=$1
  [[ $# -lt 2 ]] || name+=-$2
  [[ -f $pages/$name ]] ||
    zcat "$reference/man1/$name.1.gz" | groff -man -Tascii -P-cbou -rLL=2000n -rHY=0 >"$pages/$name"
  cat "$pages/$name"
}

offers=0
check() { # command's words
  local help words page offered word
  help=$("$bin/$1" "${@:2}" --help)
  page=$(page_of "$@")
  offered=$(completed "$@" '')
  words=$(options_in "$help"; commands_in "$help")
  [[ $words ]] || fault "$*: --help names nothing"
  for word in $words; do
    offers=$((offers + 1))
    grep -qxF -- "$word" <<<"$offered" || fault "$*: completion does not offer $word"
    grep -qE -- "(^|[ ,])$word([ ,{]|\$)" <<<"$page" || fault "$*: the page does not name $word"
  done
  for word in $(commands_in "$help"); do
    [[ $1 == tandem-view || "$1 $word" == 'tandem view' ]] || check "$@" "$word"
  done
}

programs=()
for completion in "$reference"/completions/*; do
  bash -n "$completion" || fault "$completion is no bash"
  # shellcheck disable=SC1090
  source "$completion"
  programs+=("$(basename "$completion")")
done
# tandem-bench is checked as `tandem bench`
for program in "${programs[@]}"; do [[ $program == tandem-bench ]] || check "$program"; done
[[ $offers -ge 150 ]] || fault "only $offers commands and options were looked for"

# the words of an option, as its --help has them, after a space and after "="
words=$(completed tandem contact --contact '')
[[ $words == $'plain\nrefined' || $words == $'refined\nplain' ]] || fault "tandem contact --contact offers: $words"
[[ $(completed tandem contact --contact = p) == plain ]] || fault "tandem contact --contact=p is not completed"
[[ $(completed tandem be) == bench ]] || fault "tandem be is not completed"
[[ ! $(completed tandem peer --session '') ]] || fault "the value of --session is completed with options"
[[ $(completed tandem bench frame --sch) == --schedule ]] || fault "tandem bench is not completed by tandem-bench"
if [[ " ${programs[*]} " == *' tandem-view '* ]]; then
  [[ $(completed tandem view --screenshot-a) == --screenshot-after ]] || fault "tandem view is not completed by tandem-view"
fi

for page in "$reference"/man1/*.gz; do
  said=$(zcat "$page" | LC_ALL=C groff -ww -man -Tascii -z 2>&1; zcat "$page" | grep -nP '[^\x00-\x7F]' || true)
  [[ ! $said ]] || fault "$page: $said"
done
echo "$offers commands and options, ${#programs[@]} programs, $(ls "$reference"/man1 | wc -l) pages, $faults faults"
[[ $faults = 0 ]]
