void planted(int n) {
  if (n > 0) throw n;
}
