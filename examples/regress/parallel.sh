#!/usr/bin/env bash
# A suite by several processes of this machine, one shard each, and one report of all. Exit code 0: all images passed.
#   examples/regress/parallel.sh SUITE.json OUT [SHARDS]
# With GNU parallel the shards can run on other machines that see the same folders: add --sshlogin a,b --workdir .
set -euo pipefail
suite=$1 out=$2 shards=${3:-$(nproc)}
if command -v parallel >/dev/null; then
  seq "$shards" | parallel sightline-regress "$suite" --out "$out" --shard "{}/$shards" --quiet || true
else
  seq "$shards" | xargs -P "$shards" -I{} sightline-regress "$suite" --out "$out" --shard "{}/$shards" --quiet || true
fi
exec sightline-regress "$suite" --out "$out" --merge
