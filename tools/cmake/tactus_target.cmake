# Flags that every target of the project gets, and why.
# The same bits on every machine of the instruction set, Debug or Release: never the build machine's own set, and no
# multiply-add that the source does not say. Both sets give the same bits (tests/aarch64).
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(instruction_set -march=x86-64-v3 -mno-fma)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^(aarch64|arm64)$")
  set(instruction_set -march=armv8-a)
else()
  message(FATAL_ERROR "tactus builds for x86-64-v3 and for aarch64; this machine is ${CMAKE_SYSTEM_PROCESSOR}")
endif()

add_library(tactus_flags INTERFACE)
target_compile_options(tactus_flags INTERFACE
  -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Werror
  # gcc 12 sees an overlap in std::string's own operator+ (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  ${instruction_set} -ffp-contract=off
  # What may go into a shared library is inlined as in a program: nobody replaces our functions at load time.
  $<$<BOOL:$<TARGET_PROPERTY:POSITION_INDEPENDENT_CODE>>:-fno-semantic-interposition>)
target_compile_features(tactus_flags INTERFACE cxx_std_20)
target_include_directories(tactus_flags INTERFACE ${PROJECT_SOURCE_DIR})
if(TACTUS_SANITIZE)
  # gcc 12 warns of strings that a sanitizer's own code makes (array bounds, uninitialised): there they are no errors.
  target_compile_options(tactus_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-error>)
  target_compile_options(tactus_flags INTERFACE
    -fsanitize=${TACTUS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(tactus_flags INTERFACE -fsanitize=${TACTUS_SANITIZE})
endif()

# tactus_library(NAME LINKS...): all sources of the current folder, one library.
function(tactus_library name)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_library(${name} STATIC ${sources})
  target_link_libraries(${name} PUBLIC tactus_flags ${ARGN})
endfunction()
