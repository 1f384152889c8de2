#!/usr/bin/env bash
# A slice of bench/clumsy_clients/campaign.py: three terminals whose verbs are interrupted, suspended, stopped and killed.
source "$(dirname "$0")/lib.sh"
python3 bench/clumsy_clients/campaign.py --gantry "$gantry" --runs 10 --seed 3 || failures=$((failures + 1))
