#!/bin/sh
# Writes which files it was given to its last argument (publish --shm PATH FILE).
for n in 0 1 2 3 4 5 6 7 8 9 10 11 12; do
  target=$(readlink "/proc/$$/fd/$n") && [ "$target" != "$0" ] && echo "$n $target" >>"$4.list"
done
cat "$4.list" >"$4"
rm -f "$4.list"
