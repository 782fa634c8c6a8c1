include(Batches)

# A room is a subfolder with a README.md, and a library target of its own: add_room(PREFIX ROOM TARGET...) makes
# PREFIX_ROOM from the sources in ROOM. A room may include only the rooms that its line names: scripts in
# tests/architecture read these lines, and hold the include lines and the READMEs to them.
# With room_batch its sources are compiled in batches of that many: no two names of a room meet, then.
function(add_room prefix room)
  file(GLOB sources CONFIGURE_DEPENDS "${room}/*.cpp" "src/${room}/*.cpp")
  if(sources)
    if(room_batch)
      in_batches(sources ${room} ${room_batch} ${sources})
    endif()
    add_library(${prefix}_${room} STATIC ${sources})
    target_link_libraries(${prefix}_${room} PUBLIC ${ARGN})
  else()
    add_library(${prefix}_${room} INTERFACE)
    target_link_libraries(${prefix}_${room} INTERFACE ${ARGN})
  endif()
  set_property(GLOBAL APPEND PROPERTY ${prefix}_rooms ${prefix}_${room})
endfunction()
