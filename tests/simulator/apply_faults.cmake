# cmake -D program=PATCH -D top=FOLDER -D file=FILE -D hunks=PATCHFILE -D copy=FILE -P apply_faults.cmake: writes a copy of a
# file of the tree with the faults of a patch in it. A hunk that fits nowhere ends the build.

execute_process(
  COMMAND ${program} --force --fuzz=0 --reject-file=- --output=${copy}.new ${top}/${file} ${top}/${hunks}
  RESULT_VARIABLE failed OUTPUT_VARIABLE said ERROR_VARIABLE said)
if(failed)
  file(REMOVE ${copy}.new)
  string(REGEX MATCHALL "Hunk #[0-9]+ FAILED at [0-9]+" places "${said}")
  list(JOIN places ", " places)
  # a space before it: CMake does not break the line
  message(FATAL_ERROR " ${hunks} does not fit ${file} any more (${places}): adapt it to the file's new lines")
endif()
file(RENAME ${copy}.new ${copy})
