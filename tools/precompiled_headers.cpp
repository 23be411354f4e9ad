// Has nothing of its own: its targets carry the precompiled headers of the tools' libraries (tools/CMakeLists.txt).
