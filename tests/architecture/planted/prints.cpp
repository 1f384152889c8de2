#include <cstdio>
void planted(int n) { std::printf("%d\n", n); }
