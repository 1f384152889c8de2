#!/usr/bin/env bash
# no_gpl_linked.sh PROGRAM: fails when a shared library that PROGRAM loads comes from a Debian package whose own sources are
# under the GPL. Licences are read from the packages' machine-readable copyright files ("Files: *"). The libraries of the
# compiler itself are under the GPL with its runtime exception, and their files are of another form.
set -euo pipefail
program=$1

mapfile -t libraries < <(ldd "$program" | awk '$3 ~ /^\// { print $3 }' | xargs -r -n 1 readlink -f | sort -u)
[ "${#libraries[@]}" -gt 0 ] || { echo "no_gpl_linked: $program loads nothing; is it the right file?" >&2; exit 2; }
# Debian 12 moved /lib to /usr/lib: dpkg may know a file by either name.
mapfile -t packages < <(dpkg -S "${libraries[@]}" "${libraries[@]#/usr}" 2>/dev/null | sed 's/:.*//' | sort -u)

status=0
for package in "${packages[@]}"; do
  copyright=/usr/share/doc/$package/copyright
  [ -r "$copyright" ] || continue
  licence=$(awk '/^Files:/ { all = ($2 == "*") } all && /^License:/ { sub(/^License: */, ""); print; exit }' "$copyright")
  # "GPL-2 or GPL-3" is the GPL; "GPL-2 or BSD-3-Clause" leaves a choice; LGPL and exceptions are not meant.
  if grep -qE '^GPL' <<<"$licence" && ! grep -qiE 'exception|(or|/) *(BSD|MIT|Expat|Apache|LGPL|MPL|X11|ISC|Zlib|Artistic)' <<<"$licence"; then
    echo "$program loads $package, which is under $licence"
    status=1
  fi
done
[ $status -ne 0 ] || echo "${#packages[@]} packages, none under the GPL"
exit $status
