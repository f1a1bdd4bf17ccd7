# "cmake --install" and the Debian package (target skyquilt_deb, or cpack -G DEB after a build).
# What is installed: the program, the page, manual pages, shell completions, the service with its configuration, and in
# share/doc what it is made of. Nothing of it but the program is made where python3 or dpkg are not to be had, and a
# cross build needs CMAKE_CROSSCOMPILING_EMULATOR, because pages and completions come from the program itself.
include(GNUInstallDirs)
set(package_dir ${CMAKE_CURRENT_LIST_DIR}/package)
set(made_dir ${CMAKE_BINARY_DIR}/package)
if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)  # as the tests take it
endif()
find_package(Python3 COMPONENTS Interpreter)
if(NOT Python3_FOUND)
  message(STATUS "No \"cmake --install\" and no package without python3")
  return()
endif()

# The day of pages and changelog: that of the sources, so that one commit makes one package.
set(epoch "$ENV{SOURCE_DATE_EPOCH}")
if(NOT epoch)
  execute_process(COMMAND git -C ${CMAKE_SOURCE_DIR} log -1 --format=%ct OUTPUT_VARIABLE epoch
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT epoch)
  file(TIMESTAMP ${CMAKE_SOURCE_DIR}/CHANGELOG.md epoch %s UTC)
endif()
set(dated ${CMAKE_COMMAND} -E env SOURCE_DATE_EPOCH=${epoch})
set(SKYQUILT_MAINTAINER "Skyquilt maintainers <maintainers@skyquilt.example>" CACHE STRING
    "Who answers for the Debian package: Name <address>")

set(pages ${made_dir}/man)
set(completions ${made_dir}/completions)
set(manual ${made_dir}/manual.stamp)
add_custom_command(OUTPUT ${manual}
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages} ${completions}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${completions}
  COMMAND ${dated} ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:skyquilt> man --out ${pages}
  COMMAND find ${pages} -name *.1 -exec gzip -9n {} +
  COMMAND skyquilt completion bash > ${completions}/skyquilt
  COMMAND skyquilt completion zsh > ${completions}/_skyquilt
  COMMAND skyquilt completion fish > ${completions}/skyquilt.fish
  COMMAND ${CMAKE_COMMAND} -E touch ${manual}
  DEPENDS skyquilt COMMENT "Writing manual pages and shell completions" VERBATIM)
set(sbom ${made_dir}/doc/skyquilt.cdx.json)
add_custom_command(OUTPUT ${sbom}
  COMMAND ${dated} ${Python3_EXECUTABLE} ${package_dir}/sbom.py --program $<TARGET_FILE:skyquilt> --version ${PROJECT_VERSION}
          --lock ${CMAKE_SOURCE_DIR}/web/package-lock.json --out ${sbom}
  DEPENDS skyquilt ${package_dir}/sbom.py ${CMAKE_SOURCE_DIR}/web/package-lock.json
  COMMENT "Listing what the program is made of" VERBATIM)
set(changelog ${made_dir}/doc/changelog.Debian.gz)
add_custom_command(OUTPUT ${changelog}
  COMMAND ${dated} ${Python3_EXECUTABLE} ${package_dir}/changelog.py --version ${PROJECT_VERSION}
          --maintainer ${SKYQUILT_MAINTAINER} --changes ${CMAKE_SOURCE_DIR}/CHANGELOG.md --out ${made_dir}/doc
  DEPENDS ${package_dir}/changelog.py ${CMAKE_SOURCE_DIR}/CHANGELOG.md VERBATIM)
add_custom_target(skyquilt_installed ALL DEPENDS ${manual} ${sbom} ${changelog})

install(TARGETS skyquilt RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${completions}/skyquilt DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${completions}/_skyquilt DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${completions}/skyquilt.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
set(web ${CMAKE_SOURCE_DIR}/web)
install(FILES ${web}/index.html ${web}/embed.html ${web}/favicon.svg ${web}/style.css
        DESTINATION ${CMAKE_INSTALL_DATADIR}/skyquilt/web)
# Types are for who develops the page.
install(DIRECTORY ${web}/styles ${web}/src ${web}/vendor DESTINATION ${CMAKE_INSTALL_DATADIR}/skyquilt/web
        PATTERN "*.d.mts" EXCLUDE PATTERN "*.d.ts" EXCLUDE PATTERN "made_of.sha256" EXCLUDE PATTERN "README.md" EXCLUDE
        PATTERN ".*" EXCLUDE)
install(FILES ${package_dir}/copyright ${sbom} ${changelog} ${made_dir}/doc/changelog.gz
        DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/skyquilt)
install(FILES ${package_dir}/lintian-overrides RENAME skyquilt DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides)
install(CODE "set(package_dir \"${package_dir}\")\nset(made_dir \"${made_dir}\")")
install(SCRIPT ${package_dir}/install_service.cmake)

execute_process(COMMAND ${CMAKE_SOURCE_DIR}/cmake/list_packages.sh run OUTPUT_VARIABLE run_packages
                COMMAND_ERROR_IS_FATAL ANY)
string(STRIP "${run_packages}" run_packages)
execute_process(COMMAND ${CMAKE_SOURCE_DIR}/cmake/list_packages.sh recommended OUTPUT_VARIABLE recommended_packages
                OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "\n" ", " recommended_packages "${recommended_packages}")
string(REPLACE "\n" ", " run_packages "${run_packages}")
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)  # tests need not be built for a package
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME skyquilt)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${SKYQUILT_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "maps of drone photos, served as tiles
Skyquilt takes the photos of a drone by curl, web page or folder, places
each of them on the ground by its recorded pose and by what the pictures
show, and serves the map as tiles to browsers and GIS programs. Maps are
also files: GeoTIFF, MBTiles and PMTiles.
.
The service listens to its own machine until /etc/skyquilt.conf says
otherwise.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "${recommended_packages}")
set(CPACK_DEBIAN_PACKAGE_DEPENDS "adduser, init-system-helpers (>= 1.52), ${run_packages}")
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_BINARY_DIR}/late_depends.cmake)
file(GENERATE OUTPUT ${CPACK_PROJECT_CONFIG_FILE} CONTENT
  "set(SKYQUILT_PROGRAM \"$<TARGET_FILE:skyquilt>\")\ninclude(\"${package_dir}/late_depends.cmake\")\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${package_dir}/conffiles ${package_dir}/postinst ${package_dir}/prerm ${package_dir}/postrm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
add_custom_target(skyquilt_deb
  COMMAND ${dated} ${CMAKE_CPACK_COMMAND} -G DEB --config ${CMAKE_BINARY_DIR}/CPackConfig.cmake
  DEPENDS skyquilt skyquilt_installed skyquilt_web WORKING_DIRECTORY ${CMAKE_BINARY_DIR} USES_TERMINAL VERBATIM)
