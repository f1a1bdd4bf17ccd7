# skyquilt_embed_text(out_variable FILE path NAMESPACE ns SYMBOL name)
# Makes a .cc that defines `extern const std::string_view ns::name` with the bytes of a text file, so that the one
# binary carries it. Configures again when the file changes.
function(skyquilt_embed_text out_variable)
  cmake_parse_arguments(ARG "" "FILE;NAMESPACE;SYMBOL" "" ${ARGN})
  set(source ${CMAKE_CURRENT_SOURCE_DIR}/${ARG_FILE})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
  file(READ ${source} EMBEDDED_TEXT)
  # A string literal holds at most 64 KiB by the standard's promise; adjacent pieces join.
  string(LENGTH "${EMBEDDED_TEXT}" length)
  set(pieces "")
  set(offset 0)
  while(offset LESS length)
    string(SUBSTRING "${EMBEDDED_TEXT}" ${offset} 8000 piece)
    string(APPEND pieces "R\"~sq~(${piece})~sq~\"\n")
    math(EXPR offset "${offset}+8000")
  endwhile()
  set(made ${CMAKE_CURRENT_BINARY_DIR}/${ARG_SYMBOL}.cc)
  file(CONFIGURE OUTPUT ${made} @ONLY CONTENT
    "#include <string_view>\nnamespace ${ARG_NAMESPACE} {\nextern const std::string_view ${ARG_SYMBOL};\nconst std::string_view ${ARG_SYMBOL} =\n@pieces@;\n}\n")
  set(${out_variable} ${made} PARENT_SCOPE)
endfunction()
