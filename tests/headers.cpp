// The headers that tests share are precompiled for this target (see CMakeLists.txt).
