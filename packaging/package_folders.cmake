# What cpack does with the files before it puts them into a package: everybody may look into the folders, which have the
# umask of who calls cpack (CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS gives no more than that leaves).
file(CHMOD_RECURSE "${CPACK_TEMPORARY_INSTALL_DIRECTORY}"
  DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
