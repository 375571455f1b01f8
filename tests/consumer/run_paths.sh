#!/usr/bin/env bash
# Checks every ELF file in the installed FOLDERs: its run path is relative to the file, and it does not
# contain the name of the build folder BUILT.
# usage: run_paths.sh BUILT FOLDER...
set -euo pipefail
built=$1
shift
count=0
while IFS= read -r file; do
  [ "$(head -c 4 "$file" | tr -d '\0')" = $'\x7fELF' ] || continue
  count=$((count + 1))
  paths=$(readelf -d "$file" | sed -nE 's/.*\((RUNPATH|RPATH)\).*\[(.*)\]/\2/p')
  IFS=: read -ra parts <<<"$paths"
  for part in "${parts[@]}"; do
    case $part in
      '$ORIGIN' | '$ORIGIN/'*) ;;
      *) echo "$file: its run path has '$part', expected only folders relative to \$ORIGIN" && exit 1 ;;
    esac
  done
  if grep -qaF "$built" "$file"; then echo "$file: names $built" && exit 1; fi
done < <(find "$@" -type f)
[ "$count" -gt 0 ] || { echo "no ELF file in $*" && exit 1; }
echo "run paths of $count files: passed"
