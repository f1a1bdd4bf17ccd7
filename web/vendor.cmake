# Fills web/vendor from npm when package-lock.json or scripts/vendor.js changed. Called at build time:
#   cmake -DWEB=<folder> -DDEV=ON|OFF -P vendor.cmake
# Several build folders may share this source tree, so one lock guards it. Without network, a page library that
# is already there is kept: the build must not fail in the field.
file(LOCK "${WEB}/.vendor.lock" GUARD PROCESS TIMEOUT 900)

file(SHA256 "${WEB}/package-lock.json" lock)
file(SHA256 "${WEB}/scripts/vendor.js" script)
string(SHA256 wanted "${lock}${script}")
set(present "")
if(EXISTS "${WEB}/vendor/made_of.sha256")
  file(READ "${WEB}/vendor/made_of.sha256" present)
endif()

set(current FALSE)
if(wanted STREQUAL present AND (NOT DEV OR EXISTS "${WEB}/node_modules/playwright-core"))
  set(current TRUE)
endif()

if(NOT current)
  find_program(NPM npm)  # here, because run.sh installs it while the compiler runs
  if(NOT NPM)
    message(WARNING "npm was not found: the map library cannot be put into web/vendor (apt install npm).")
    set(result 1)
  else()
    set(omit "")
    if(NOT DEV)
      set(omit "--omit=dev")
    endif()
    execute_process(COMMAND "${NPM}" ci --loglevel=error --no-audit --no-fund --ignore-scripts ${omit}
                    WORKING_DIRECTORY "${WEB}" RESULT_VARIABLE result OUTPUT_QUIET)
    if(result EQUAL 0)
      execute_process(COMMAND "${NPM}" run --silent vendor WORKING_DIRECTORY "${WEB}" RESULT_VARIABLE result)
    endif()
  endif()
  if(NOT result EQUAL 0)
    if(EXISTS "${WEB}/vendor/maplibre-gl.mjs")
      message(WARNING "npm did not answer; the map library already in web/vendor is kept.")
    else()
      message(FATAL_ERROR "The page's map library is missing and npm could not install it. Connect to the "
                          "network once and build again.")
    endif()
  endif()
endif()
