#!/bin/bash
# A sweep by GNU parallel, on this machine or on those of a file of ssh names that all see the same folders and have catena on their path:
#     doc/many_machines/parallel.sh SWEEP.toml OUT SHARDS [--sshloginfile MACHINES]
# Run again, it goes on where it stopped. Each shard takes all cores of its machine, so that parallel starts one at a time on each.
set -euo pipefail
sweep=$(realpath "$1") out=$(realpath -m "$2") shards=$3
shift 3
catena=${CATENA:-catena}
parallel --jobs 1 --halt soon,fail=1 "$@" "$catena sweep $sweep -o $out/shard-{} --shard {}/$shards --quiet" ::: $(seq "$shards")
"$catena" sweep --merge $(seq -f "$out/shard-%g" "$shards") -o "$out/all"
