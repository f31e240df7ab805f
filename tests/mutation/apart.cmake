# Read after project() of a build for mutate.py: what it changes is compiled file by file, so that a changed copy of one file
# takes the place of that file's object alone.
cmake_language(DEFER CALL set_target_properties
  tandem_safety safety_test tandem_collab tandem_dds PROPERTIES UNITY_BUILD OFF)
