# CPack reads it when it makes the package: dpkg-shlibdeps knows the libraries that the program links to, and this those that it
# loads when they are first needed, from its note ".note.dlopen".
execute_process(
  COMMAND sh -c "PATH=$PATH:/sbin:/usr/sbin; readelf -p .note.dlopen '${SKYQUILT_PROGRAM}' | grep -o 'lib[^\"]*\\.so[.0-9]*' | sort -u | while read -r so; do
    file=$(ldconfig -p | awk -v so=\"$so\" '$1 == so { print $NF; exit }')
    dpkg-query -S \"*/$(basename \"$(readlink -f \"$file\")\")\" | head -1 | cut -d: -f1
  done | sort -u"
  OUTPUT_VARIABLE late OUTPUT_STRIP_TRAILING_WHITESPACE)
if(late)
  string(REPLACE "\n" ", " late "${late}")
  string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS ", ${late}")
endif()
