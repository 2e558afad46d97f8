#!/usr/bin/env bash
# Mutation testing: see scripts/mutate.py --help.
exec python3 "$(dirname "$0")/mutate.py" "$@"
