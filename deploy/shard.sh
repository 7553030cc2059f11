#!/usr/bin/env bash
# Segments one share of a list of clips: every SHARDS-th line, from line SHARD on. Run it once for each share, on any number
# of machines. A share can always be run again: it processes only what is missing.
#
#   shard.sh LIST OUT [OPTION...]     the options are those of `tracecut segment`
#
# SHARD (0 to SHARDS - 1) comes from the environment, else from a Slurm array or an indexed Job of Kubernetes. SHARDS comes
# from the environment and must be the same in all runs. LIST has one clip per line; empty lines and lines that begin with #
# are skipped, but counted. Line n, counted from 0, goes to OUT/00000n-NAME. If something went wrong, beside it is one of
#
#   00000n-NAME.failed      the clip cannot be read: the command and its error. Tried again when the clip or the options change
#   00000n-NAME.truncated   the clip is damaged, so its results end early: the command and its error
#   00000n-NAME.log         the clip failed for a reason that may go away. Tried again in the next run, after all other clips
#
# Exit code: 0 if each clip is done, truncated or cannot be read; 1 if clips are left for another run; 2 for wrong use;
# 130 or 143 if a signal ended it.
set -uo pipefail

# Exit codes of `tracecut` (docs/cli.md).
WRONG_USE=2
BAD_DATA=3

# end CODE MESSAGE: prints the message and ends.
end() {
  printf 'shard.sh: %s\n' "$2" >&2
  exit "$1"
}

# require_number NAME VALUE: ends unless the value is a whole number.
require_number() {
  [[ $2 =~ ^[0-9]+$ ]] || end 2 "$1 = '$2' (expected a whole number)"
}

[ $# -ge 2 ] || end 2 'expected LIST OUT [OPTION...]'
list=$1
out=$2
shift 2

shard=${SHARD:-${SLURM_ARRAY_TASK_ID:-${JOB_COMPLETION_INDEX:-}}}
shards=${SHARDS:-}
require_number SHARD "$shard"
require_number SHARDS "$shards"
shard=$((10#$shard))
shards=$((10#$shards))
((shard < shards)) || end 2 "SHARD = $shard (expected 0 to $((shards - 1)), as SHARDS = $shards)"

# These may exist in the next run, or on another machine.
[ -r "$list" ] && [ ! -d "$list" ] || end 1 "the list $list cannot be read"
command -v tracecut >/dev/null || end 1 'there is no tracecut on the PATH'
mkdir -p -- "$out" || exit 1

# A signal ends the command, which keeps its finished windows, and then the share. Bash makes its children ignore SIGINT.
child=
stop_code=
stop() {
  stop_code=$1
  [ -z "$child" ] || kill -s TERM "$child" 2>/dev/null
}
trap 'stop 130' INT
trap 'stop 143' TERM

# segment LOG CLIP PLACE OPTION...: runs the command and waits until it ends, even if signals arrive.
segment() {
  local log=$1 clip=$2 place=$3 code
  shift 3
  # A path must not be taken for an option or standard input.
  case $clip in -*) clip=./$clip ;; esac
  tracecut segment "$clip" --out "$place" --resume --quiet "$@" 2>"$log" &
  child=$!
  # A signal may have come before the child was known.
  [ -z "$stop_code" ] || kill -s TERM "$child" 2>/dev/null
  while :; do
    wait "$child"
    code=$?
    # If a signal interrupted the wait, the code is the signal's and the command is still running.
    if ((code <= 128)) || ! kill -0 "$child" 2>/dev/null; then break; fi
  done
  child=
  return "$code"
}

# place_of NUMBER CLIP: prints the folder of the clip's results.
place_of() {
  local name=${2%/}
  name=${name##*/}
  printf '%s/%06d-%s' "$out" "$1" "${name%.*}"
}

# is_noted NOTE CLIP COMMAND: true if the note is about this command and the clip has not changed since.
is_noted() {
  local noted
  [ -f "$1" ] && [ ! "$2" -nt "$1" ] && IFS= read -r noted <"$1" && [ "$noted" = "$3" ]
}

# write_note NOTE LOG COMMAND: turns a log into a note.
write_note() {
  { printf '%s\n' "$3" && cat "$2"; } >"$1.part" && mv "$1.part" "$1" && rm "$2"
}

is_truncated() {
  grep -qs '"truncated": {' "$1/result.json"
}

num_done=0
num_truncated=0
num_unreadable=0
num_failed=0

# process NUMBER CLIP OPTION...: writes the results of one clip, or a note on why there are none.
process() {
  local number=$1 clip=$2 place command code
  shift 2
  place=$(place_of "$number" "$clip")
  printf -v command '%q ' tracecut segment "$clip" "$@"
  command=${command% }
  if is_noted "$place.failed" "$clip" "$command"; then
    num_unreadable=$((num_unreadable + 1))
    return
  fi
  rm -f "$place.failed"
  segment "$place.log" "$clip" "$place" "$@"
  code=$?
  [ -z "$stop_code" ] || exit "$stop_code"
  if ((code == 0)); then
    rm -f "$place.log" "$place.truncated"
    num_done=$((num_done + 1))
  elif ((code == BAD_DATA)) && is_truncated "$place" && write_note "$place.truncated" "$place.log" "$command"; then
    num_truncated=$((num_truncated + 1))
  elif ((code == BAD_DATA)) && write_note "$place.failed" "$place.log" "$command"; then
    num_unreadable=$((num_unreadable + 1))
  else
    cat "$place.log" >&2
    # Options that are wrong for a clip without any results are wrong for all.
    if ((code == WRONG_USE)) && [ ! -e "$place" ] && [ ! -e "$place.partial" ]; then
      rm -f "$place.log"
      exit 2
    fi
    printf 'shard.sh: line %d: %s: exit code %d\n' "$((number + 1))" "$clip" "$code" >&2
    num_failed=$((num_failed + 1))
  fi
}

# The numbers of the share's clips. Clips that failed come last, as they may bring the whole share down again.
clips=()
fresh=
failed=
number=-1
while IFS= read -r clip || [ -n "$clip" ]; do
  number=$((number + 1))
  ((number % shards == shard)) || continue
  # Windows editors write a byte order mark and carriage returns.
  ((number > 0)) || clip=${clip#$'\xef\xbb\xbf'}
  clip=${clip%$'\r'}
  if [[ $clip =~ ^[[:space:]]*$ || $clip == '#'* ]]; then continue; fi
  clips[number]=$clip
  if [ -e "$(place_of "$number" "$clip").log" ]; then failed+=" $number"; else fresh+=" $number"; fi
done <"$list"

for number in $fresh $failed; do
  [ -z "$stop_code" ] || exit "$stop_code"
  process "$number" "${clips[number]}" "$@"
done
printf 'shard.sh: share %d of %d: %d done, %d truncated, %d cannot be read, %d failed\n' \
  "$shard" "$shards" "$num_done" "$num_truncated" "$num_unreadable" "$num_failed"
((num_failed == 0))
