# COMMAND with a mount namespace of its own:  "${with_mounts[@]}" COMMAND. What it mounts it takes away itself: in a chroot,
# whose root is no mount, others may see it.
with_mounts=(unshare -m)
"${with_mounts[@]}" true 2>/dev/null || with_mounts=(unshare -m --propagation unchanged)
