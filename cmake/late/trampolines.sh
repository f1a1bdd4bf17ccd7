#!/bin/bash
# trampolines.sh OUT.S NM READELF ARCHIVE LIBRARY.so...: for each function that the objects of ARCHIVE ask of a LIBRARY, a trampoline of
# its name that loads the library when it is first called, and a note that says so (".note.dlopen", as systemd specifies it).
set -euo pipefail
export LC_ALL=C
out=$1 nm=$2 readelf=$3 archive=$4
shift 4
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$nm" -u "$archive" | awk 'NF == 2 && $1 == "U" { print $2 }' | sort -u > "$scratch/asked"
{
  echo '#include "cmake/late/x86_64.S"'
  for library; do
    soname=$("$readelf" -d "$library" | sed -n 's/.*(SONAME).*\[\(.*\)\].*/\1/p')
    # Where the loader does not look, the whole path is asked for, as a linked program would by its RPATH.
    folder=$(dirname "$(realpath "$library")")
    case $folder in
      /lib | /lib/* | /usr/lib | /usr/lib/* | /usr/local/lib | /usr/local/lib/*) place=$soname ;;
      *) place=$folder/$soname ;;
    esac
    name=${soname%%.so*}
    name=${name//[^A-Za-z0-9]/_}
    # The default version of each symbol: "f" or "f@@V1", not "f@V0".
    "$nm" -D --defined-only "$library" | awk '$3 !~ /[^@]@[^@]/ { sub(/@@.*/, "", $3); print $3, $2 }' | sort -u -k1,1 \
      | join "$scratch/asked" - > "$scratch/here"
    if grep -v ' [TWi]$' "$scratch/here" >&2; then
      echo "trampolines.sh: $archive uses data of $soname, which cannot be loaded late." >&2
      exit 1
    fi
    [ -s "$scratch/here" ] || continue
    echo "    LATE_LIBRARY $name, $place, $(wc -l < "$scratch/here")"
    awk -v library="$name" '{ printf "    LATE_FUNCTION %s, %d, %s\n", library, NR - 1, $1 }' "$scratch/here"
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
} > "$scratch/trampolines.S"
mv "$scratch/trampolines.S" "$out"
