#!/usr/bin/env bash
# One share of a list of clips: every SHARDS-th of its lines, from line SHARD on. Run it once for each share, on as many
# machines as there are; whatever was done before is passed over, so a share may be run again after anything.
#
#   shard.sh LIST OUT [OPTION...]     the options are those of `tracecut segment`
#
# SHARD (0 to SHARDS - 1) and SHARDS come from the environment, else from a Slurm array or an indexed Job of Kubernetes
# (there SHARDS has to be set to its `completions`). LIST has one clip a line. Clip n goes to OUT/00000n-NAME; one that
# cannot be read leaves OUT/00000n-NAME.failed with the reason, and the others go on. Exit code: 0 when all clips are done or
# are no clips; 1 when others failed, which a second run may mend; 2 for wrong use; 130 and 143 when it was interrupted.
set -uo pipefail

BAD_INPUT=3

usage() {
  printf 'shard.sh: %s\n' "$1" >&2
  exit 2
}

# whole NAME VALUE: ends unless it is a whole number.
whole() {
  [[ $2 =~ ^[0-9]+$ ]] || usage "$1 = '$2' (expected a whole number)"
}

[ $# -ge 2 ] || usage 'expected LIST OUT [OPTION...]'
list=$1
out=$2
shift 2
[ -r "$list" ] || usage "the list $list cannot be read"

shard=${SHARD:-}
shards=${SHARDS:-}
if [ -z "$shard" ] && [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
  shard=$((SLURM_ARRAY_TASK_ID - ${SLURM_ARRAY_TASK_MIN:-0}))
  shards=${shards:-${SLURM_ARRAY_TASK_COUNT:-}}
fi
shard=${shard:-${JOB_COMPLETION_INDEX:-}}
whole SHARD "$shard"
whole SHARDS "$shards"
((10#$shard < 10#$shards)) || usage "SHARD = $shard (expected 0 to $((10#$shards - 1)), as SHARDS = $shards)"

mkdir -p "$out" || exit 1

# A signal is passed on: the command keeps what it has, and the share ends.
child=
stopped=
stop() {
  stopped=$1
  [ -z "$child" ] || kill -s "$2" "$child" 2>/dev/null
}
trap 'stop 130 INT' INT
trap 'stop 143 TERM' TERM

# segment CLIP PLACE OPTION...: runs the command, and waits for it through signals.
segment() {
  local clip=$1 place=$2 code
  shift 2
  tracecut segment "$clip" --out "$place" --resume --quiet "$@" 2>"$place.log" &
  child=$!
  while :; do
    wait "$child"
    code=$?
    kill -0 "$child" 2>/dev/null || break
  done
  child=
  return "$code"
}

line=-1
failed=0
while IFS= read -r clip || [ -n "$clip" ]; do
  line=$((line + 1))
  if [ -z "$clip" ] || ((line % 10#$shards != 10#$shard)); then continue; fi
  name=$(basename -- "$clip")
  place=$out/$(printf '%06d' "$line")-${name%.*}
  if [ -e "$place" ] || [ -e "$place.failed" ]; then continue; fi
  segment "$clip" "$place" "$@"
  code=$?
  [ -z "$stopped" ] || exit "$stopped"
  case $code in
    0) rm -f "$place.log" ;;
    "$BAD_INPUT") mv "$place.log" "$place.failed" ;;
    2)
      cat "$place.log" >&2
      exit 2
      ;;
    *)
      printf '%s: exit code %d, see %s\n' "$clip" "$code" "$place.log" >&2
      failed=$((failed + 1))
      ;;
  esac
done <"$list"
((failed == 0))
