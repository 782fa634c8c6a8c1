# What the other processors under Linux share; the files beside this one set INBETWEEN_PROCESSOR and include it.
# The compiler is Debian's cross compiler, and the libraries are Debian's packages for that processor, which lie beside
# those of this machine: CMake looks into the compiler's own folder of them, pkg-config has to be told.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR "${INBETWEEN_PROCESSOR}")
set(CMAKE_CXX_COMPILER "${INBETWEEN_PROCESSOR}-linux-gnu-g++")
set(CMAKE_CXX_FLAGS_INIT "-Wno-psabi")  # GCC notes that std::pair is passed otherwise than before GCC 10.1
set(CMAKE_LIBRARY_ARCHITECTURE "${INBETWEEN_PROCESSOR}-linux-gnu")
set(ENV{PKG_CONFIG_LIBDIR} "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/pkgconfig:/usr/share/pkgconfig")
# What is built is run here as well: the tests do, and whoever writes the manual pages.
set(CMAKE_CROSSCOMPILING_EMULATOR "qemu-${INBETWEEN_PROCESSOR}")
