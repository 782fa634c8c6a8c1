# A room is a subfolder with a README.md, and a library target of its own: add_room(PREFIX ROOM TARGET...) makes
# PREFIX_ROOM from the sources in ROOM. It may include what it links to; tests/architecture holds the include lines.
function(add_room prefix room)
  file(GLOB sources CONFIGURE_DEPENDS "${room}/*.cpp" "src/${room}/*.cpp")
  if(sources)
    add_library(${prefix}_${room} STATIC ${sources})
    target_link_libraries(${prefix}_${room} PUBLIC ${ARGN})
  else()
    add_library(${prefix}_${room} INTERFACE)
    target_link_libraries(${prefix}_${room} INTERFACE ${ARGN})
  endif()
  set_property(GLOBAL APPEND PROPERTY ${prefix}_rooms ${prefix}_${room})
endfunction()
