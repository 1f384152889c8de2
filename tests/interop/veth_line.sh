# Sourced by the scripts that let strangers talk over a wire: a veth pair in a namespace of its own, and a folder for what
# comes out; both go when the script ends. The far end, while it runs, is the process $far.
#   name=gim$$; source tests/interop/veth_line.sh      # in the project's folder
work=$(mktemp -d)
if ! scripts/veth-pair up $name >"$work/pair" 2>&1; then
  cat "$work/pair"
  rm -rf "$work"
  [ "$(id -u)" = 0 ] && exit 1
  echo "only root may make a veth pair: nothing to test"
  exit 77
fi
far=
finish() {
  [ -n "$far" ] && kill "$far" 2>/dev/null
  wait 2>/dev/null
  scripts/veth-pair down $name >/dev/null 2>&1
  rm -rf "$work"
}
trap finish EXIT
