#!/bin/sh
# usage: cmake/list_packages.sh SECTION...   the packages of these sections of cmake/packages.txt, one a line.
set -eu
for section in "$@"; do
  awk -v wanted="[$section]" '
    /^#/ || /^$/ { next }
    /^\[/ { inside = $0 == wanted; if (inside) found = 1; next }
    inside
    END { if (!found) { print "packages.txt has no section " wanted > "/dev/stderr"; exit 1 } }' "$(dirname "$0")/packages.txt"
done
