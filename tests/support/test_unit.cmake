# cmake -DUNIT=FILE -DSOURCES=FILE,... -P test_unit.cmake: writes a source that compiles several test files at once. It
# includes the headers of all of them, then each file in a namespace of its own, so that no file's names meet
# another's; the headers that a file includes there are guarded, and add nothing.
string(REPLACE "," ";" sources "${SOURCES}")
set(headers)
set(files)
set(number 0)
foreach(source ${sources})
  file(STRINGS ${source} lines REGEX "^#include ")
  list(APPEND headers ${lines})
  math(EXPR number "${number} + 1")
  string(APPEND files "namespace test_file_${number} {\n#include \"${source}\"\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(JOIN headers "\n" headers)
file(WRITE ${UNIT} "${headers}\n${files}")
