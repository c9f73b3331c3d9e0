#!/usr/bin/env bash
# Makes the figures of the guide anew, with the program as it is now.
#
#     docs/scripts/figures.sh [LOC_SIM]
#
# The guide names them: figures/SCENARIO/FILE.svg is FILE.svg of `loc-sim run SCENARIO`, and
# figures/SCENARIO_METHOD_../FILE.svg that of `loc-sim run SCENARIO --method METHOD ..`; the method
# `smooth` stands for the option of that name. figures/study/ is the study that study.md shows.
# Figures that no page shows are removed.
set -euo pipefail
loc_sim=${1:+$(realpath "$1")}
cd "$(dirname "$0")/.."

if [ -z "$loc_sim" ]; then
  cargo build --release --quiet --locked -p loc-sim
  loc_sim=${CARGO_TARGET_DIR:-../target}/release/loc-sim
fi
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

wanted=$(grep -oh 'figures/[a-z0-9_-]*/[a-z0-9-]*\.svg' src/*.md | sort -u)
for run in $(echo "$wanted" | cut -d/ -f2 | sort -u); do
  if [ "$run" = study ]; then
    "$loc_sim" study landmark-drive --runs 100 --vary filter.particles=100,500,2000 \
      --method mcl --method ekf --quiet --out "$scratch/study"
    continue
  fi
  IFS=_ read -ra words <<<"$run"
  options=()
  for word in "${words[@]:1}"; do
    if [ "$word" = smooth ]; then options+=(--smooth); else options+=(--method "$word"); fi
  done
  "$loc_sim" run "${words[0]}" "${options[@]}" --quiet --out "$scratch/$run"
done
rm -rf src/figures
for figure in $wanted; do
  mkdir -p "src/$(dirname "$figure")"
  cp "$scratch/${figure#figures/}" "src/$figure"
done
du -sh src/figures
