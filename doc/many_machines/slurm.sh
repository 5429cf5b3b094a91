#!/bin/bash
# A sweep as a Slurm array, one shard a task:
#     sbatch --array=1-100 doc/many_machines/slurm.sh SWEEP.toml OUT
# Tasks that were lost or preempted are submitted again under their numbers (sbatch --array=7,31 ...), and go on where they stopped.
#SBATCH --job-name=catena-sweep
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=8
#SBATCH --mem-per-cpu=1G
#SBATCH --time=04:00:00
#SBATCH --signal=B:INT@60
#SBATCH --requeue
set -euo pipefail
sweep=$1 out=$2
shards=${SHARDS:-${SLURM_ARRAY_TASK_MAX:?start it with sbatch --array=1-N}}
exec "${CATENA:-catena}" sweep "$sweep" -o "$out/shard-$SLURM_ARRAY_TASK_ID" --shard "$SLURM_ARRAY_TASK_ID/$shards" \
    --jobs "${SLURM_CPUS_PER_TASK:-1}" --progress 60
