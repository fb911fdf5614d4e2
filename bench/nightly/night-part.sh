#!/bin/sh
#SBATCH --job-name=tactbench-night
#SBATCH --cpus-per-task=2
#SBATCH --open-mode=truncate
# One part of a night that several machines carry out; `tactbench runs merge` puts the parts together.
#
#   night-part.sh PARTS FOLDER SUITE [options of nightly]
#
# Which part: SLURM_ARRAY_TASK_ID, as a job array of Slurm sets it, or PART. The part's store becomes FOLDER/part-K.db; one
# that is there already is left alone, so that the same command carries out what is missing. FOLDER must be seen by every
# machine. The store is made on a disk of the machine's own, since SQLite does not write on a network's disk, and is copied
# under another name first, so that a store with its own name is whole. TACTBENCH: the program, where it is not in PATH.
# Ends with 0 when the part is there, also with red scenarios, which are the night's result; else as nightly does.
set -eu
if [ $# -lt 3 ]; then
  echo "usage: night-part.sh PARTS FOLDER SUITE [options of nightly]" >&2
  exit 2
fi
parts=$1 folder=$2
shift 2
part=${SLURM_ARRAY_TASK_ID:-${PART:?names the part}}
if [ -e "$folder/part-$part.db" ]; then exit 0; fi
scratch=$(mktemp -d "${SLURM_TMPDIR:-${TMPDIR:-/tmp}}/tactbench-part.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
code=0
"${TACTBENCH:-tactbench}" nightly "$@" --shard "$part/$parts" --db "$scratch/part.db" || code=$?
case $code in
  0 | 1 | 6) ;;  # as expected, a scenario is red, one moved
  *) exit "$code" ;;
esac
cp "$scratch/part.db" "$folder/part-$part.db.new"
mv "$folder/part-$part.db.new" "$folder/part-$part.db"
