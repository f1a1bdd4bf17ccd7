#!/bin/bash
# late_stubs.sh OUT.S NM ARCHIVE LIBRARY.so...: for each function that the objects of ARCHIVE ask of a LIBRARY, a stub of its
# name that loads the library when it is first called, and a note that says so (".note.dlopen", as systemd specifies it).
set -euo pipefail
export LC_ALL=C
out=$1 nm=$2 archive=$3
shift 3
asked=$(mktemp) here=$(mktemp)
trap 'rm -f "$asked" "$here"' EXIT
"$nm" -u "$archive" | awk 'NF == 2 && $1 == "U" { print $2 }' | sort -u > "$asked"
{
  echo '#include "cmake/late/x86_64.S"'
  for library; do
    soname=$(readelf -d "$library" | sed -n 's/.*(SONAME).*\[\(.*\)\].*/\1/p')
    name=${soname%%.so*}
    name=${name//[^A-Za-z0-9]/_}
    "$nm" -D --defined-only "$library" | awk '{ sub(/@.*/, "", $3); print $3, $2 }' | sort -u | join "$asked" - > "$here"
    if grep -v ' [TWi]$' "$here" >&2; then
      echo "late_stubs.sh: $archive uses data of $soname, which cannot be loaded late." >&2
      exit 1
    fi
    [ -s "$here" ] || { echo "late_stubs.sh: $archive uses nothing of $soname." >&2; exit 1; }
    echo "    LATE_LIBRARY $name, $soname, $(wc -l < "$here")"
    awk -v library="$name" '{ printf "    LATE_FUNCTION %s, %d, %s\n", library, NR - 1, $1 }' "$here"
    json="[{\"soname\":[\"$soname\"],\"priority\":\"required\"}]"
    cat << NOTE
    .section .note.dlopen, "a"
    .balign 4
    .long 4, 2f - 1f, 0x407c0c0a
    .asciz "FDO"
1:  .asciz "${json//\"/\\\"}"
2:  .balign 4
NOTE
  done
} > "$out"
