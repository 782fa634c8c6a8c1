# What cpack reads before it makes a package.
# The same sources give the same bytes: every file carries the time of the commit.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git log -1 --format=%ct WORKING_DIRECTORY "${CMAKE_CURRENT_LIST_DIR}"
    OUTPUT_VARIABLE time OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
  if(status EQUAL 0)
    set(ENV{SOURCE_DATE_EPOCH} "${time}")
  else()
    message(WARNING "git does not tell the time of the commit, so the package has other bytes each time; set SOURCE_DATE_EPOCH")
  endif()
endif()
# dpkg-shlibdeps looks for the libraries of another processor where it is told of it.
if(CPACK_DEBIAN_PACKAGE_ARCHITECTURE)
  set(ENV{DEB_HOST_ARCH} "${CPACK_DEBIAN_PACKAGE_ARCHITECTURE}")
endif()
