#!/bin/bash
#SBATCH --job-name=tactus-sweep --ntasks=1 --cpus-per-task=1
# A sweep as an array of Slurm, a unit a job, on nodes that share this folder and have tactus at the same path:
#   tactus sweep gains.toml --list > units.txt
#   sbatch --array=1-$(wc -l < units.txt) slurm_array.sh units.txt
#   tactus sweep gains.toml --collect --csv gains.csv
set -euo pipefail
command=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$1")
eval "exec $command"
