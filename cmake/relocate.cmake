# Python wheels of ROS packages name the include directories of the machine they were built on
# (/opt/python/cp3xx/...). Passed as CMAKE_PROJECT_INCLUDE, this replaces them by those of the Python found
# here, once every find_package of the project has run. On a ROS installed by other means it changes nothing.

function(bearing_twin_relocate_imported_targets)
  find_package(Python3 QUIET COMPONENTS Interpreter Development NumPy)
  get_property(targets DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(directories ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(NOT directories MATCHES "/opt/python/")
      continue()
    endif()
    set(kept "")
    foreach(directory IN LISTS directories)
      if(directory MATCHES "/opt/python/")
        list(APPEND kept ${Python3_INCLUDE_DIRS} ${Python3_NumPy_INCLUDE_DIRS})
      else()
        list(APPEND kept "${directory}")
      endif()
    endforeach()
    list(REMOVE_DUPLICATES kept)
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept}")
  endforeach()
endfunction()

cmake_language(DEFER CALL bearing_twin_relocate_imported_targets)
