// Has nothing of its own: its target carries the precompiled header of the tests (tests/CMakeLists.txt).
